"""The files that an order leaves: the .blend, and of each take its motion, labels and pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...atomic_file import atomic_write
from ...blender.actions import keyframes
from ...blender.cast.baking import CastResult
from ...blender.character import character, characters
from ...blender.render import preview
from ...blender.scene import open_scene, read_scene
from ...blender.takes import baking, seen
from ...body import amass
from ...errors import SampError
from ..order import Order


@dataclass(frozen=True)
class _Baked:
    """One character's take in the open scene. number: in a cast, else 0. entry: what the report says of it."""

    seed: int
    number: int
    owner: Any
    action: Any
    entry: dict


def write(context: Any, made: Order, result: baking.Result | CastResult) -> list[Path]:
    """Write the files that are asked for, and note them in the report; return them. Raise SampError.

    The pictures come last, for they change the open scene.
    """
    files = []
    if made.output:
        open_scene.save_copy(made.output)
        files.append(made.output)
    takes = list(_baked(result))
    if made.npz is not None:
        files += _motions(made, takes)
    if made.dataset is not None:
        files += _labels(context, made, takes)
    for variant in result.variants:
        shown = [take for take in takes if take.seed == variant["seed"]]
        if made.preview is not None:
            files.append(_preview(context, made, variant, shown))
        if made.frames:
            files += _frames(context, made, variant, shown)
    return files


def _baked(result: baking.Result | CastResult) -> Iterator[_Baked]:
    """Yield all takes, those of a cast seed by seed."""
    if not isinstance(result, CastResult):
        for variant, action in zip(result.variants, result.actions, strict=True):
            yield _Baked(variant["seed"], 0, result.owner, action, variant)
        return
    for variant in result.variants:
        seed = variant["seed"]
        present = [number for number, own in result.actions.items() if seed in own]
        for number, entry in zip(present, variant["cast"], strict=True):
            yield _Baked(seed, number, result.owners[number], result.actions[number][seed], entry)


def _motions(made: Order, takes: list[_Baked]) -> list[Path]:
    paths = made.npz_paths()
    return [
        _written(
            take,
            "npz",
            paths[take.seed, take.number],
            lambda part, take=take: amass.write_amass(keyframes.read_motion(take.owner, take.action), part),
        )
        for take in takes
    ]


def _labels(context: Any, made: Order, takes: list[_Baked]) -> list[Path]:
    from ...blender.dataset import labels  # with scipy's trees, which no other order needs

    paths, geometry = made.dataset_paths(), read_scene.read_scene(context, characters.people(context))
    files = []
    for take in takes:
        motion, _ = seen.shown_motion(context, take.owner, take.action)
        content = labels.arrays(motion, geometry, character.body_of(take.owner)) | _facts(made, take)
        path = paths[take.seed, take.number]
        files.append(
            _written(take, "dataset", path, lambda part, content=content: _compressed(part, content))
        )
    return files


def _facts(made: Order, take: _Baked) -> dict[str, np.ndarray]:
    """Return what a take is, for its labels; without what its method does not know."""
    names = (
        "seed",
        "action",
        "target",
        "frame_start",
        "interaction_start",
        "goal_position",
        "goal_direction",
    )
    known = {name: take.entry.get(name) for name in names} | {"scene": made.scene_name()}
    return {name: np.array(value) for name, value in known.items() if value is not None}


def _compressed(part: Path, content: dict[str, np.ndarray]) -> None:
    with part.open("wb") as file:
        np.savez_compressed(file, **content)


def _written(take: _Baked, option: str, path: Path, write_part: Callable[[Path], object]) -> Path:
    """Write a take's file whole, and note it in the report. option: without dashes, the one that names its folder."""
    try:
        with atomic_write(path) as part:
            write_part(part)
    except OSError as error:
        raise SampError(f"'{path.parent}' cannot be written ({error}); choose another --{option}.") from error
    take.entry[option] = str(path.absolute())
    return path


def _preview(context: Any, made: Order, variant: dict, shown: list[_Baked]) -> Path:
    """Write the picture of a take, or of all takes of a cast's seed."""
    for take in shown:
        keyframes.activate_action(take.owner, take.action)
    path = made.preview_paths()[variant["seed"]]
    variant["preview"] = str(path.absolute())
    preview.write(context, shown[0].owner, shown[0].action, path)
    return path


def _frames(context: Any, made: Order, variant: dict, shown: list[_Baked]) -> list[Path]:
    """Write what the camera sees of a take, or of all takes of a cast's seed."""
    from ...blender.dataset import pictures

    for take in shown:
        keyframes.activate_action(take.owner, take.action)
    numbers = pictures.chosen(variant["frame_start"], variant["frame_end"], made.frames)
    folder, target = made.frame_folders()[variant["seed"]], variant.get("target") or ""
    files = pictures.write(context, made.camera, numbers, folder, target.split(",")[-1])
    variant["frames"] = str(files[-1].absolute())
    return files
