"""Train encoders, then the parts of the generators, and then several runs in parallel, on one GPU within a time limit.

python -m samp_blender.training.scene_gan.gpu --data train.bin --output OUT --seconds 560 --pretrain 130 --parts 240
    --run all:width=128,draws=4,context_weight=0.02 --run csgn:width=256 [--test test.bin]

--data are files written by data/packing.py. With --parts, runs with two generators begin with a dense part of the pose
generator (trained beside the encoders) and a trajectory generator, both trained without critics. Each training is a
separate process, since a single one is limited by the launch of small kernels. The results are written to OUT as one
archive in pieces of at most 16 MiB; `join` restores it:

python -m samp_blender.training.scene_gan.gpu --join OUT --output FOLDER
"""

from __future__ import annotations

import argparse
import io
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path

import numpy as np

from .data import packing
from .learning import options

MOST = 16 * 2**20 - 4096  # largest size of a piece, bytes
PIECES = 4
MODULE = __package__
KEPT = ("*.safetensors", "*.sha256", "*.json", "*.jsonl", "*.txt", "*.png")
PACKING = 25.0  # seconds reserved at the end for the archive
PARTS = ("rough_", "way_")  # prefixes of the folders of parts
ENCODER_WIDTH = "64"
SIZES = ("width", "noise", "pose_noise", "encoder_width")
ROUGH = ("--part", "rough_pose", "--draws", "2", "--batch", "1024", "--rate", "5e-4", "--moving", "0.6")
WAY = ("--part", "trajectory", "--draws", "8", "--batch", "256", "--rate", "5e-4")


def parse_run(text: str) -> tuple[str, dict[str, str]]:
    """Parse ROW:KEY=VALUE,KEY=VALUE; return the row and its options."""
    name, _, rest = text.partition(":")
    if name not in options.ROWS:
        raise argparse.ArgumentTypeError(f"unknown row '{name}'; choose one of {', '.join(options.ROWS)}")
    return name, dict(pair.split("=", 1) for pair in filter(None, rest.split(",")))


def encoder_name(row: options.Options, changes: dict[str, str]) -> str:
    """Return the name of the encoder that a row with changes needs."""
    width = changes.get("encoder_width", ENCODER_WIDTH)
    depth = "" if row.depth or row.settings.view == "height" else "_without_depth"
    return f"encoder_{row.settings.view}{depth}_{width}"


def archive(folder: Path, output: Path) -> list[Path]:
    """Write the result files of a folder as pieces scene_gan.0, ...; return their paths.

    Files are added from the smallest to the largest; those that exceed PIECES pieces are left out, and so are the
    weights of parts, which the runs contain.
    """
    wanted = lambda path: path.suffix != ".safetensors" or not path.parent.name.startswith(PARTS)
    found = {path for pattern in KEPT for path in folder.rglob(pattern) if wanted(path)}
    files = sorted(found, key=lambda path: path.stat().st_size)
    held, room = io.BytesIO(), MOST * PIECES - 2**20
    with tarfile.open(fileobj=held, mode="w") as tar:
        for path in files:
            if path.stat().st_size + 1024 > room:
                print(f"left out: {path.relative_to(folder)}", flush=True)
                continue
            room -= path.stat().st_size + 1024
            tar.add(path, arcname=str(path.relative_to(folder)))
    body = held.getvalue()
    parts = []
    for number, at in enumerate(range(0, len(body), MOST)):
        parts.append(output / f"scene_gan.{number}")
        parts[-1].write_bytes(body[at : at + MOST])
    return parts


def join(folder: Path, output: Path) -> None:
    """Restore the files of an archive."""
    parts = sorted(folder.glob("scene_gan.[0-9]"))
    with tarfile.open(fileobj=io.BytesIO(b"".join(part.read_bytes() for part in parts))) as tar:
        tar.extractall(output, filter="data")


def flags(settings: dict[str, str]) -> list[str]:
    """Return the command-line options of settings."""
    return [part for key, value in settings.items() for part in (f"--{key.replace('_', '-')}", value)]


def parts_of(row: options.Options, changes: dict[str, str]) -> dict[str, list[str]]:
    """Return the options of the parts that a run begins with, by the names of their folders; none for CSGN."""
    if not row.settings.separate:
        return {}
    sizes = {name: changes[name] for name in SIZES if name in changes}
    suffix = "_".join(sizes.values())
    made = flags({"view": row.settings.view} | sizes)
    common = ["--critics", "--no-sheet", "--checkpoint", "1000"]
    return {
        f"{PARTS[0]}{suffix}": [*ROUGH, *common, *made],
        f"{PARTS[1]}{encoder_name(row, changes)}_{suffix}": [*WAY, *common, *made],
    }


def start(module: str, work: Path, arguments: list[str]) -> subprocess.Popen:
    """Start a program of this package; its output is written to a file in its folder."""
    work.mkdir(parents=True, exist_ok=True)
    with (work / "output.txt").open("w") as out:
        command = [sys.executable, "-u", "-m", f"{MODULE}.{module}", "--work", str(work), *arguments]
        return subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT)


def wait(running: dict[str, subprocess.Popen], until: float) -> None:
    """Wait for programs until a time, and kill those that are still running."""
    for name, process in running.items():
        try:
            code = process.wait(max(until - time.time(), 1))
        except subprocess.TimeoutExpired:
            process.kill()
            code = "late"
        print(f"{name}: {code}", flush=True)


class Programs:
    """The trainings of one call. chosen: its options. scratch: folder of the unpacked data. work: folder of the
    trainings. began: time of the start."""

    def __init__(self, chosen: argparse.Namespace, scratch: Path, work: Path, began: float) -> None:
        self.chosen, self.scratch, self.work, self.began = chosen, scratch, work, began
        self.common = ["--data", str(scratch / "train"), "--device", chosen.device]
        self.rows = [(row, options.ROWS[row], changes) for row, changes in chosen.run]

    def run(self) -> None:
        """Pretrain the encoders, with the dense parts beside them; train the trajectories; then all runs."""
        rough: dict[str, subprocess.Popen] = {}
        encoders = self._encoders()
        self._parts(PARTS[0], rough)
        wait(encoders, self.began + self.chosen.pretrain + 20)
        ways: dict[str, subprocess.Popen] = {}
        self._parts(PARTS[1], ways)
        wait(rough | ways, self.began + self.chosen.parts + 10)
        self._runs()

    def _encoders(self) -> dict[str, subprocess.Popen]:
        """Start the encoders of all runs, which end at chosen.pretrain."""
        found: dict[str, subprocess.Popen] = {}
        for _, base, changes in self.rows:
            name = encoder_name(base, changes)
            if name in found:
                continue
            width = changes.get("encoder_width", ENCODER_WIDTH)
            extra = ["--view", base.settings.view, "--encoder-width", width, "--batch", "128",
                     "--seconds", str(self.began + self.chosen.pretrain - time.time())]  # fmt: skip
            if not base.depth:
                extra += ["--tasks", "classes"]
            if self.chosen.test is not None:
                extra += ["--test", str(self.scratch / "test")]
            found[name] = start("pretrain", self.work / name, self.common + extra)
        return found

    def _parts(self, kind: str, running: dict[str, subprocess.Popen]) -> None:
        """Start the parts of a kind, of PARTS, that the runs begin with; they end at chosen.parts."""
        for _, base, changes in self.rows if self.chosen.parts else ():
            for name, extra in parts_of(base, changes).items():
                if name.startswith(kind) and name not in running:
                    end = ["--seconds", str(self.began + self.chosen.parts - time.time())]
                    encoder = [] if kind == PARTS[0] else self._encoder(base, changes)
                    running[name] = start(
                        "learning.train", self.work / name, self.common + extra + encoder + end
                    )

    def _encoder(self, base: options.Options, changes: dict[str, str]) -> list[str]:
        return ["--encoder", str(self.work / encoder_name(base, changes))]

    def _runs(self) -> None:
        """Train all runs until the end."""
        found: dict[str, subprocess.Popen] = {}
        until = self.began + self.chosen.seconds - PACKING
        for row, base, changes in self.rows:
            name = row if row not in found else f"{row}_{len(found)}"
            parts = parts_of(base, changes) if self.chosen.parts else {}
            extra = ["--row", row, *self._encoder(base, changes),
                     "--seconds", str(until - time.time() - 5), "--checkpoint", "120", "--report", "10",
                     *(["--begin", *(str(self.work / part) for part in parts)] if parts else []),
                     *flags({"batch": str(self.chosen.batch)} | changes)]  # fmt: skip
            found[name] = start("learning.train", self.work / name, self.common + extra)
        wait(found, until)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, nargs="+", help="files of packing.py, used together")
    parser.add_argument("--test", type=Path, nargs="+")
    parser.add_argument("--join", type=Path, metavar="OUT")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--seconds", type=float, default=560.0, help="duration of the program")
    parser.add_argument("--pretrain", type=float, default=130.0, help="seconds of it used for the encoders")
    parser.add_argument(
        "--parts",
        type=float,
        default=0.0,
        help="seconds until the parts of the generators end (default: none)",
    )
    parser.add_argument("--run", action="append", type=parse_run, default=[], metavar="ROW:KEY=VALUE,...")
    parser.add_argument("--batch", type=int, default=256)
    parser.add_argument("--work", type=Path, help="folder to leave all files in, instead of an archive")
    parser.add_argument("--device", default="cuda")
    chosen = parser.parse_args(arguments)
    if chosen.join is not None:
        join(chosen.join, chosen.output)
        return 0
    if chosen.data is None or not chosen.run:
        parser.error("--data and at least one --run are required")
    began = time.time()
    chosen.output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        sources = {"train": chosen.data} | ({"test": chosen.test} if chosen.test else {})
        for split, paths in sources.items():
            (scratch / split).mkdir()
            for name, values in packing.joined([packing.unpack(path, 12) for path in paths]).items():
                np.save(scratch / split / f"{name}.npy", values)
        print(f"unpacked after {time.time() - began:.0f} s", flush=True)
        work = chosen.work or scratch / "work"
        Programs(chosen, scratch, work, began).run()
        for path in archive(work, chosen.output) if chosen.work is None else ():
            print(f"{path.name}: {path.stat().st_size / 2**20:.1f} MiB", flush=True)
    print(f"done after {time.time() - began:.0f} s", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
