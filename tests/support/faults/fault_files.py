"""Faults of files: a full disk, folders that cannot be written, broken takes."""

from __future__ import annotations

import contextlib
import os
import resource
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
from faults import Case, Press, Room, bake_batch, nothing, press, with_take
from samp_blender.samp_addon.body import amass
from samp_blender.tests.support.blender import rigs

BROKEN = {
    "nothing in it": b"",
    "other bytes": b"not an npz file at all",
    "the beginning of a zip": b"PK\x03\x04" + b"\x00" * 40,
}


@contextlib.contextmanager
def full_disk(size: int = 2000) -> Iterator[None]:
    """Limit files of this process to ``size`` bytes: writes fail as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def on_full_disk(act: Press, size: int = 2000) -> Press:
    """Press while the disk is full; existing files stay and no partial file is left."""

    def go(room: Room) -> None:
        before = listing(room.files)
        try:
            with full_disk(size):
                act(room)
        finally:
            after = listing(room.files)
            assert {name: after.get(name) for name in before} == before
            assert set(after) - set(before) <= {"room.blend"}, after

    return go


def listing(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def export(name: str) -> Press:
    return lambda room: bpy.ops.samp.export_npz("EXEC_DEFAULT", True, filepath=str(room.files / name))


def older_file(name: str) -> Press:
    """A take, and an existing file at the path of its export."""

    def arrange(room: Room) -> None:
        with_take(room)
        (room.files / name).write_bytes(b"an older take")

    return arrange


def unwritable(room: Room) -> str:
    """Return a folder that cannot be written; permissions do not stop root."""
    if os.geteuid() == 0:
        return "/proc/self"
    folder = room.files / "locked"
    folder.mkdir(mode=0o500)
    return str(folder)


def export_unwritable(room: Room) -> object:
    return bpy.ops.samp.export_npz("EXEC_DEFAULT", True, filepath=f"{unwritable(room)}/take.npz")


def a_folder_in_the_way(room: Room) -> None:
    with_take(room)
    (room.files / "take.npz").mkdir()


def a_file_in_the_way(room: Room) -> None:
    with_take(room)
    (room.files / "takes").write_text("not a folder")


def bake(name: str = "take.npz") -> Press:
    return lambda room: bpy.ops.samp.bake("EXEC_DEFAULT", True, filepath=str(room.files / name))


def content(data: bytes) -> Press:
    return lambda room: (room.files / "take.npz").write_bytes(data)


def half(room: Room) -> None:
    path = amass.write_amass(rigs.take(60), room.files / "take.npz")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def changed(**parts: object) -> Press:
    """Write a take's file with other content; None removes an array."""

    def arrange(room: Room) -> None:
        path = amass.write_amass(rigs.take(10), room.files / "take.npz")
        with np.load(path) as data:
            kept = dict(data)
        for key, value in parts.items():
            kept.pop(key, None)
            if value is not None:
                kept[key] = value
        np.savez(path, **kept)

    return arrange


def flipped(room: Room) -> None:
    """Write a take's file with one wrong byte."""
    path = amass.write_amass(rigs.take(60), room.files / "take.npz")
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(bytes(data))


NOT_NUMBERS = np.full((10, 165), np.nan, np.float32)


def batch(**options: str) -> Press:
    """Return a run of the batch with files in the case's folder."""
    return lambda room: bake_batch(room, **{name: room.files / text for name, text in options.items()})


def with_report(room: Room) -> None:
    """Run the batch with a report only."""
    bake_batch(room, report=room.files / "r.json")


def after_a_first_run(**options: str) -> Press:
    """Save the room for the batch, with output files of an earlier run."""

    def arrange(room: Room) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=str(room.files / "room.blend"), copy=True)
        for name, text in options.items():
            if name != "npz":
                (room.files / text).write_bytes(b"of the run before")

    return arrange


# The batch reopens the file: only the files on disk are compared.
BATCH = (".*",)
CASES = (
    Case(
        "export to a full disk",
        with_take,
        message="cannot be written",
        press=on_full_disk(export("take.npz")),
    ),
    Case(
        "export over an older file on a full disk",
        older_file("take.npz"),
        message="cannot be written",
        press=on_full_disk(export("take.npz")),
    ),
    Case(
        "export to a folder that cannot be written",
        with_take,
        message="choose another folder",
        press=export_unwritable,
    ),
    Case(
        "export below a file",
        a_file_in_the_way,
        message="choose another folder",
        press=export("takes/take.npz"),
    ),
    Case("export onto a folder", a_folder_in_the_way, message="choose another", press=export("take.npz")),
    Case(
        "export to a name with quotes and an emoji",
        with_take,
        press=export('Anna\'s "🛋" take.npz'),
        owner=None,
    ),
    Case("export without a name", with_take, message="No file was named", press=press("export_npz")),
    Case(
        "batch to a full disk",
        after_a_first_run(output="out.blend"),
        message="'.*out.blend' cannot be written",
        press=on_full_disk(batch(output="out.blend")),
        changes=BATCH,
    ),
    Case(
        "batch with a report to a full disk",
        after_a_first_run(report="r.json"),
        message="r.json' cannot be written",
        press=on_full_disk(with_report, 200),
        changes=BATCH,
    ),
    Case(
        "batch with takes to a full disk",
        after_a_first_run(npz="takes"),
        message="cannot be written",
        press=on_full_disk(batch(npz="takes")),
        changes=BATCH,
    ),
    *(
        Case(f"take with {what}", content(data), message="choose an AMASS", press=bake())
        for what, data in BROKEN.items()
    ),
    Case("half a take", half, message="choose an AMASS", press=bake()),
    Case("take with a wrong byte", flipped, message="choose an AMASS|numbers|AMASS motion", press=bake()),
    Case("take without poses", changed(poses=None, root_orient=None), message="needs poses", press=bake()),
    Case("take with NaN poses", changed(poses=NOT_NUMBERS), message="not numbers", press=bake()),
    Case(
        "take with infinite positions",
        changed(trans=np.full((10, 3), np.inf, np.float32)),
        message="not numbers",
        press=bake(),
    ),
    *(
        Case(
            f"take with {rate} frames a second",
            changed(mocap_frame_rate=np.array(float(rate))),
            message="frame",
            press=bake(),
        )
        for rate in ("0", "-30", "nan", "inf", "1e9")
    ),
    Case(
        "take with a rate in words",
        changed(mocap_frame_rate=np.array("thirty")),
        message="frame",
        press=bake(),
    ),
    Case(
        "take with a list of rates",
        changed(mocap_frame_rate=np.array([30.0, 30.0])),
        message="frame",
        press=bake(),
    ),
    Case(
        "take with positions of another length",
        changed(trans=np.zeros((3, 3))),
        message="needs poses",
        press=bake(),
    ),
    Case(
        "take with poses in words",
        changed(poses=np.full((10, 165), "a"), root_orient=None),
        message="AMASS",
        press=bake(),
    ),
    Case(
        "take with Python objects", changed(poses=np.array([{}], dtype=object)), message="AMASS", press=bake()
    ),
    Case(
        "a folder as take",
        lambda room: (room.files / "take.npz").mkdir(),
        message="choose an AMASS",
        press=bake(),
    ),
    Case("no such take", nothing, message="There is no file", press=bake()),
)
