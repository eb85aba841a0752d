"""Train all networks of the long-term method on one GPU within a time limit.

python -m samp_blender.training.long_term.side_by_side --data long_term.bin --output OUT --seconds 560
python -m samp_blender.training.long_term.side_by_side --data long_term.bin --output OUT --seconds 240 --begin WEIGHTS
python -m samp_blender.training.long_term.side_by_side --join OUT WEIGHTS

With --begin, prior and points are taken from another training and the other networks are trained on from its weights.
Steps are limited by the latency of small kernels, so three programs share the GPU: prior and sub-goal bodies; points,
routes and poses; the networks of the paper for table 1. The weights are written as one archive in pieces of less than
16 MiB, OUT/weights.0, OUT/weights.1, ...; --join extracts it.
"""

from __future__ import annotations

import argparse
import io
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

MOST = 16 * 2**20 - 4096  # largest size of a piece, bytes
SAVING = 20.0  # seconds reserved for the archive
FIRST = 0.14  # share of the time for prior and points
ROUTE = 0.33  # for the routes
KEPT = ("prior", "points")  # stages that --begin takes over
PAPER = ("paper_route", "paper_pose", "paper_route_t", "paper_pose_r", "paper_pose_rt", "paper_base")


@dataclass(frozen=True)
class Worker:
    """One program: stages and the seconds of each; the last stage runs until the end."""

    name: str
    stages: tuple[str, ...]
    seconds: tuple[float, ...]


def workers(seconds: float, paper: bool, begun: bool = False) -> list[Worker]:
    """Return the programs that share the GPU. begun: whether prior and points are trained already."""
    first, route = FIRST * seconds, ROUTE * seconds
    made = [
        Worker("bodies", ("prior", "sub_goal")[begun:], (first, 0.0)[begun:]),
        Worker("motion", ("points", "route", "pose")[begun:], (first, route, 0.0)[begun:]),
    ]
    if paper:
        each = (1 - FIRST - 0.1) * seconds / len(PAPER)
        made.append(Worker("paper", PAPER, (each,) * len(PAPER)))
    return made


def start(worker: Worker, work: Path, end: float, options: argparse.Namespace) -> subprocess.Popen:
    """Start a program; its output is written to OUT/NAME.txt."""
    command = [sys.executable, "-m", f"{__package__}.train", "--data", str(options.data), "--work", str(work)]
    command += ["--stages", *worker.stages, "--seconds", *(f"{s:.1f}" for s in worker.seconds)]
    command += ["--until", f"{end:.1f}", "--wait", "600", *(["--cpu"] if options.cpu else [])]
    command += ["--begin", str(options.begin), "--rate", str(options.rate)] if options.begin else []
    log = (options.output / f"{worker.name}.txt").open("w")
    return subprocess.Popen(
        command, stdout=log, stderr=subprocess.STDOUT, env=os.environ | {"PYTHONUNBUFFERED": "1"}
    )


def archive(work: Path, output: Path) -> int:
    """Write all finished weights of a folder in pieces; return their number."""
    held = io.BytesIO()
    with tarfile.open(fileobj=held, mode="w") as file:
        for path in sorted(work.glob("long_term_*.s*")):
            file.add(path, path.name)
    body = held.getvalue()
    parts = [body[at : at + MOST] for at in range(0, len(body), MOST)]
    for number, part in enumerate(parts):
        (output / f"weights.{number}").write_bytes(part)
    return len(parts)


def join(output: Path, target: Path) -> list[str]:
    """Extract an archive; return the names of the files."""
    parts = sorted(output.glob("weights.*"), key=lambda path: int(path.suffix[1:]))
    target.mkdir(parents=True, exist_ok=True)
    with tarfile.open(fileobj=io.BytesIO(b"".join(part.read_bytes() for part in parts))) as file:
        file.extractall(target, filter="data")
        return file.getnames()


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path)
    parser.add_argument("--output", type=Path)
    parser.add_argument("--seconds", type=float, default=560.0, help="duration of the program")
    parser.add_argument("--no-paper", action="store_true", help="without the networks of table 1")
    parser.add_argument("--begin", type=Path, help="folder with weights of another training")
    parser.add_argument("--rate", type=float, default=6e-4, help="learning rate with --begin")
    parser.add_argument("--cpu", action="store_true")
    parser.add_argument("--join", type=Path, nargs=2, metavar=("OUT", "WEIGHTS"))
    options = parser.parse_args(arguments)
    if options.join:
        print("\n".join(join(*options.join)))
        return
    end = time.time() + options.seconds - SAVING
    options.output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        for path in options.begin.glob("long_term_*.s*") if options.begin else ():
            if path.stem.removeprefix("long_term_") in KEPT:
                shutil.copy(path, work)
        running = [
            start(worker, work, end, options)
            for worker in workers(options.seconds - SAVING, not options.no_paper, options.begin is not None)
        ]
        while any(program.poll() is None for program in running) and time.time() < end + SAVING / 2:
            time.sleep(0.5)
        for program in running:
            if program.poll() is None:
                program.kill()
        count = archive(work, options.output)
    print(f"{count} pieces; programs ended with {[program.wait() for program in running]}")


if __name__ == "__main__":
    main()
