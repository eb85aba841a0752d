"""One order of the batch: a job, the file it is for, and the files it leaves."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..methods import registry
from ..methods.step import Step
from ..pipeline.cast.cast import Cast
from ..pipeline.job import Job
from . import cast_entries

PATHS = ("scene", "output", "npz", "report", "preview", "dataset")
MOST_FRAMES = 1000
IMPORT = ("units", "up")  # how an imported scene is read
ROW = ("action", "target", "to", "method")  # options that steps in a row have one each of


@dataclass(frozen=True)
class Order:
    """A job of the batch: what to make, from which file, and what to write. Paths are as the user gave them.

    frames: how many pictures of each take, by the camera of that name, or the scene's active one. opened: the file that
    Blender has open, where no scene is named. overwrite: whether the output may replace the scene's own file.
    """

    job: Job | Cast
    scene: Path | None = None
    output: Path | None = None
    npz: Path | None = None
    report: Path | None = None
    preview: Path | None = None
    dataset: Path | None = None
    frames: int = 0
    camera: str = ""
    opened: Path | None = None
    overwrite: bool = False
    units: str | None = None
    up: str | None = None

    def npz_paths(self) -> dict[tuple[int, int], Path]:
        """Return where each take goes, by its seed and its number in a cast: named after scene, action, target, seed.

        Takes of a job that is no cast have the number 0.
        """
        return self._take_paths(self.npz, ".npz")

    def preview_paths(self) -> dict[int, Path]:
        """Return where the picture of each seed's takes goes, named as the first one."""
        paths = self._take_paths(self.preview, ".png")
        return {seed: path for (seed, number), path in paths.items() if number == 0}

    def dataset_paths(self) -> dict[tuple[int, int], Path]:
        """Return where the labels of each take go, as `npz_paths`."""
        return self._take_paths(self.dataset, ".labels.npz")

    def frame_folders(self) -> dict[int, Path]:
        """Return the folder of each seed's pictures with depth, named as the first take."""
        paths = self._take_paths(self.dataset, ".frames")
        return {seed: path for (seed, number), path in paths.items() if number == 0}

    def scene_name(self) -> str:
        """Return the name of the scene's file, without its folder and suffix."""
        return (self.scene or self.opened or Path("untitled")).stem

    def _take_paths(self, folder: Path, suffix: str) -> dict[tuple[int, int], Path]:
        scene = self.scene_name()
        if isinstance(self.job, Cast):
            rows = [([member.name], member.job) for member in self.job.members]
        else:
            rows = [([], self.job)]
        found, stems = {}, set()
        for number, (names, job) in enumerate(rows):
            words = [scene, *names, *(word for step in job.steps for word in (step.action, step.target))]
            stem = re.sub(r"[^\w.-]+", "_", "_".join(word for word in words if word))
            stem = f"{stem}_{number}" if stem in stems else stem
            stems.add(stem)
            found |= {(seed, number): folder / f"{stem}_{seed}{suffix}" for seed in self.job.seeds}
        return found

    def options(self) -> dict[str, Any]:
        """Return the options in force, as JSON holds them; paths absolute."""
        found = _of_cast(self.job) if isinstance(self.job, Cast) else _of_job(self.job)
        for name in ("scene", "output", "npz"):
            path = getattr(self, name)
            found[name] = None if path is None else str(path.absolute())
        found |= {name: getattr(self, name) for name in IMPORT if getattr(self, name) is not None}
        for name in ("preview", "dataset"):
            if getattr(self, name) is not None:
                found[name] = str(getattr(self, name).absolute())
        if self.frames:
            found |= {"frames": self.frames, "camera": self.camera}
        return json.loads(json.dumps(found))


def order(options: Mapping[str, Any], opened: Path | None = None) -> Order:
    """Return the order of parsed options, see command_line.parse. Raise UsageError for unusable ones.

    opened: the file that Blender has open.
    """
    pictures = _pictures(options)
    if "cast" in options:
        given = options["cast"]
        if pictures:
            options = {name: value for name, value in options.items() if name != "camera"}
        entries = cast_entries.read(Path(given)) if isinstance(given, str) else cast_entries.checked(given)
        job: Job | Cast = cast_entries.cast(entries, options, _job)
    else:
        job = _job(options)
    made = Order(
        job,
        **{name: Path(options[name]) for name in PATHS if name in options},
        **{name: options[name] for name in IMPORT if name in options},
        **pictures,
        opened=opened,
        overwrite=options.get("overwrite", False),
    )
    if (made.units or made.up) and (made.scene is None or made.scene.suffix.lower() == ".blend"):
        raise UsageError("--units and --up are for imported scenes, such as .obj; scale a .blend in Blender.")
    if all(place is None for place in (made.output, made.npz, made.report, made.dataset)):
        raise UsageError("Say where the result goes with --output, --npz, --dataset or --report.")
    if made.output is not None and made.output.suffix != ".blend":
        raise UsageError(f"--output is '{made.output}'; name a .blend file.")
    scene = made.scene or opened
    if made.output is not None and scene is not None and not made.overwrite and _same(made.output, scene):
        raise UsageError(
            f"--output is the scene '{scene.name}' itself; name another file, or add --overwrite to replace it."
        )
    return made


def _pictures(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return frames and camera of the pictures that are asked for. Raise UsageError for unusable ones."""
    if "frames" not in options:
        return {}
    if "dataset" not in options:
        raise UsageError("--frames writes pictures beside the labels of a take; say where with --dataset.")
    if not 1 <= options["frames"] <= MOST_FRAMES:
        raise UsageError(f"--frames is {options['frames']}; choose from 1 to {MOST_FRAMES}.")
    return {"frames": options["frames"], "camera": options.get("camera", "")}


def _job(options: Mapping[str, Any]) -> Job:
    """Return the job of parsed options. Raise UsageError for unusable ones."""
    steps = _row(options)
    methods = {step["method"]: registry.find(step["method"]) for step in steps}
    own = {option.name for method in methods.values() for option in method.options}
    plain = {f.name for f in fields(Job)} - {"settings", "then", *ROW}
    if "frames" in options:
        own |= {"frames", "camera"}
    foreign = sorted(set(options) - own - plain - {*PATHS, *IMPORT, *ROW, "overwrite", "cast"})
    if foreign:
        named = (
            f"method '{steps[0]['method']}' has"
            if len(methods) == 1
            else f"methods {', '.join(methods)} have"
        )
        raise UsageError(f"The {named} no option '{foreign[0]}'; leave it out.")
    first, *rest = [Step(**step, settings=_settings(options, step, len(steps))) for step in steps]
    values = {name: options[name] for name in plain & set(options)}
    if "shape" in values:
        values["shape"] = dict(values["shape"])
    if "start" in values:
        values["start"] = tuple(values["start"])
    if "hand" in values:
        values["hand"] = tuple(values["hand"])
    if "via" in values:
        values["via"] = _triples(values["via"])
    return Job(**{name: getattr(first, name) for name in (*ROW, "settings")}, **values, then=tuple(rest))


def _of_job(job: Job) -> dict[str, Any]:
    """Return the options of a job."""
    found = {f.name: getattr(job, f.name) for f in fields(Job)}
    found["settings"], found["shape"] = dict(job.settings), dict(job.shape)
    for name in ("shape", "hand"):
        if not found[name]:
            del found[name]
    found["then"] = [_of_step(step, job) for step in job.then]
    return found


def _of_step(step: Step, job: Job) -> dict[str, Any]:
    """Return what a step has of its own; its method and settings where they are not the first one's."""
    found = {name: getattr(step, name) for name in ROW if name != "method"}
    if step.method != job.method:
        found["method"] = step.method
    if step.settings != job.settings:
        found["settings"] = dict(step.settings)
    return found


def _of_cast(cast: Cast) -> dict[str, Any]:
    """Return the options of a cast."""
    found = {name: getattr(cast, name) for name in ("seed", "variants", "refine")}
    own = ("name", "delay", "targets", "look_at")
    found["cast"] = [
        _of_job(member.job) | {name: getattr(member, name) for name in own} for member in cast.members
    ]
    return found


def _same(one: Path, two: Path) -> bool:
    """Whether two names are of the same file, by whatever links they lead there."""
    return os.path.realpath(one) == os.path.realpath(two)


def _row(options: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return action, target, place and method of each step. Raise UsageError.

    An option that is repeated gives one step each; one text with commas is split. A --to belongs to the walks without
    a target, in order.
    """
    actions, targets = list(options.get("action", [""])), list(options.get("target", []))
    if len(actions) == 1 and "," in actions[0]:
        actions = _split(actions[0])
        targets = _split(targets[0]) if len(targets) == 1 else targets
    places = [tuple(place) for place in options.get("to", [])]
    if len(targets) > len(actions):
        raise UsageError(f"There are {len(targets)} targets for {len(actions)} actions; name one for each.")
    targets += [""] * (len(actions) - len(targets))
    rows = zip(actions, targets, _methods(options, len(actions)), strict=True)
    steps = [{"action": action, "target": target, "method": method} for action, target, method in rows]
    if len(steps) == 1:
        if len(places) > 1:
            raise UsageError(f"There are {len(places)} places --to for one action; name one.")
        return [step | ({"to": places[0]} if places else {}) for step in steps]
    walks = [step for step in steps if step["action"] in ("walk", "run") and not step["target"]]
    if places and len(walks) != len(places):
        raise UsageError(f"There are {len(places)} places --to for {len(walks)} walks without a target.")
    for step, place in zip(walks, places, strict=False):
        step["to"] = place
    return steps


def _methods(options: Mapping[str, Any], count: int) -> list[str]:
    """Return the method of each step. Raise UsageError where there are neither one for all nor one each."""
    found = options.get("method", [registry.DEFAULT])
    found = [found] if isinstance(found, str) else list(found)
    if len(found) == 1:
        found = _split(found[0]) if "," in found[0] else found * count
    if len(found) != count:
        raise UsageError(
            f"There are {len(found)} methods for {count} actions; name one for all, or one for each."
        )
    return found


def _settings(options: Mapping[str, Any], step: Mapping[str, Any], count: int) -> dict[str, Any]:
    """Return the options that a step's method has alone.

    Among several steps, places such as sub-goals belong to those without an action.
    """
    known = registry.find(step["method"]).options
    return {
        option.name: _hashable(options[option.name])
        for option in known
        if option.name in options and (count == 1 or not option.repeated or not step["action"])
    }


def _split(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _triples(numbers: list[float]) -> tuple[tuple[float, ...], ...]:
    """Return the places of a flat list of numbers. The last one is short where numbers are missing."""
    return tuple(tuple(numbers[k : k + 3]) for k in range(0, len(numbers), 3))


def _hashable(value: object) -> object:
    return tuple(map(_hashable, value)) if isinstance(value, list) else value
