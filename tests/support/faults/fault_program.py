"""Faults of the installation: weights missing or damaged, no torch, no body."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import bpy
from faults import Case, Press, Room, nothing, sit
from samp_blender.models import weights
from samp_blender.samp_addon.body import human


def with_weights(damage: Press) -> Press:
    """Return a press of Sit Here with the real networks and a damaged copy of their files."""

    def go(room: Room) -> object:
        folder = room.files / "weights"
        folder.mkdir()
        for path in weights.FOLDER.iterdir():
            if path.suffix in (".safetensors", ".sha256"):
                (folder / path.name).write_bytes(path.read_bytes())
        damage(folder)
        with mock.patch.object(weights, "FOLDER", folder):
            return sit(room)

    return go


def missing(name: str):
    return lambda folder: (folder / name).unlink()


def cut(name: str):
    return lambda folder: (folder / name).write_bytes((folder / name).read_bytes()[:1000])


def bit(name: str):
    def damage(folder: Path) -> None:
        data = bytearray((folder / name).read_bytes())
        data[-7] ^= 1
        (folder / name).write_bytes(bytes(data))

    return damage


def without_torch(room: Room) -> object:
    """Press Sit Here as in the build without torch."""
    with mock.patch.dict(sys.modules, {"torch": None}):
        return sit(room)


def without_body(room: Room) -> object:
    with mock.patch.object(human, "ASSET", room.files / "human.npz"), fresh(human.load):
        return bpy.ops.samp.create_character("EXEC_DEFAULT", True)


@contextlib.contextmanager
def fresh(*cached: object) -> Iterator[None]:
    """Clear the caches of these functions before and after."""
    for function in cached:
        function.cache_clear()
    try:
        yield
    finally:
        for function in cached:
            function.cache_clear()


CASES = (
    *(
        Case(
            f"{how} {name}",
            nothing,
            message="install the add-on again",
            networks=True,
            press=with_weights(damage(f"{name}.safetensors")),
        )
        for name in ("motion_net", "goal_net")
        for how, damage in (("missing", missing), ("cut", cut), ("bit of", bit))
    ),
    Case(
        "missing checksum",
        nothing,
        message="install the add-on again",
        networks=True,
        press=with_weights(missing("motion_net.sha256")),
    ),
    Case("no torch", nothing, message="[Tt]orch", press=without_torch, networks=True),
    Case("no body file", nothing, message="install the add-on again", press=without_body),
)
