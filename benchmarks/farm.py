"""Compare ways to bake a jobs file: one process, two parts at once, Open Job Description and Dask.

python -m samp_blender.benchmarks.farm --lines 40
python -m samp_blender.benchmarks.farm --lines 500 --ways dask --workers 4 --kill-every 30

Prints for each way the time, whether its takes are bit for bit equal to the first way's, and for Dask the cost of
killed workers. The exit status is 1 where takes differ or are missing.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..samp_addon.batch.farm.chunks import Chunk, Work, bake_chunk, chunks

ROOT = Path(__file__).resolve().parent.parent
BAKE = ROOT / "bake.py"
TARGETS = ("Sofa", "Armchair")
WAYS = ("one", "parts", "openjd", "dask")
PAGE = 4096  # bytes


@dataclass(frozen=True)
class Setting:
    """The setting of all ways. folder: with room.blend and night.jsonl. kill_every: seconds, or None."""

    folder: Path
    lines: int
    workers: int
    chunk: int
    kill_every: float | None


def prepare(folder: Path, lines: int, scene: Path | None, hold: float) -> None:
    """Write room.blend and night.jsonl. scene: another room with a Sofa and an Armchair. hold: seconds."""
    room = folder / "room.blend"
    if scene is not None:
        shutil.copy(scene, room)
    else:
        build = f"import bpy, runpy; runpy.run_path({str(ROOT / 'demo' / 'build_room.py')!r}, run_name='__main__')"
        subprocess.run([sys.executable, "-c", build, str(room)], check=True, stdout=subprocess.DEVNULL)
    shared = {"scene": "room.blend", "action": "sit", "hold": hold}
    jobs = [shared | {"target": TARGETS[seed % len(TARGETS)], "seed": seed} for seed in range(lines)]
    (folder / "night.jsonl").write_text("".join(json.dumps(job) + "\n" for job in jobs))


def one(setting: Setting) -> list[str]:
    """Bake all lines in one process."""
    _check(_start(setting, "one"))
    return []


def parts(setting: Setting) -> list[str]:
    """Bake as many parts as there are workers at the same time, and merge."""
    count = setting.workers
    started = [
        _start(setting, "parts", "--part", f"{k}/{count}", report=f"{k}.json") for k in range(1, count + 1)
    ]
    for process in started:
        _check(process)
    reports = [str(setting.folder / "parts" / f"{k}.json") for k in range(1, count + 1)]
    _check(_start(setting, "parts", "--merge", *reports, baking=False))
    return []


def openjd(setting: Setting) -> list[str]:
    """Run the template of Open Job Description, one task after the other."""
    program = shutil.which("openjd", path=str(Path(sys.executable).parent)) or "openjd"
    values = {
        "JobsFile": setting.folder / "night.jsonl", "Lines": setting.lines, "ChunkSize": setting.chunk,
        "OutputFolder": setting.folder / "openjd", "Blender": sys.executable, "BakeScript": BAKE, "OnFailure": "fail",
    }  # fmt: skip
    command = [program, "run", str(ROOT / "farm" / "openjd" / "template.yaml"), "--step", "Merge"]
    command += ["--run-dependencies", *(text for k, v in values.items() for text in ("-p", f"{k}={v}"))]
    _check(subprocess.Popen(command, stdout=subprocess.DEVNULL))
    return []


def dask(setting: Setting) -> list[str]:
    """Bake chunks on workers of Dask, some of which are killed."""
    from ..samp_addon.batch.farm import dask_cluster

    folder = setting.folder
    options = {"jobs": str(folder / "night.jsonl"), "npz": str(folder / "dask" / "npz")}
    work = Work(options, str(folder), str(folder / "dask" / "parts"))
    pieces = chunks(range(1, setting.lines + 1), setting.chunk)
    with (
        dask_cluster.connected(f"local:{setting.workers}", ":0") as client,
        _killing(client, setting) as killed,
    ):
        failed, lost = dask_cluster.bake_all(client, work, pieces, 3, bake=noted_chunk)
    return [f"{failed} lines failed, {len(lost)} chunks lost", *_account(folder / "dask.log", killed)]


def noted_chunk(work: Work, chunk: Chunk) -> int:
    """Bake a chunk on a worker; log its start and end, and the memory of the process."""
    _note(work, "begun", chunk)
    failed = bake_chunk(work, chunk)
    _note(work, "done", chunk)
    return failed


def _note(work: Work, what: str, chunk: Chunk) -> None:
    resident = int(Path("/proc/self/statm").read_text().split()[1]) * PAGE // 2**20
    with (Path(work.folder) / "dask.log").open("a") as file:
        file.write(f"{what} {chunk.name} {os.getpid()} {resident}\n")


def _account(log: Path, killed: list[int]) -> list[str]:
    """Return lines on the cost of killed workers, and on the growth of the workers' memory, MB."""
    rows = [line.split() for line in log.read_text().splitlines()]
    begun = Counter(name for what, name, *_ in rows if what == "begun")
    lines = [f"{len(killed)} workers killed, {sum(count - 1 for count in begun.values())} chunks begun again"]
    memory: dict[str, list[int]] = {}
    for what, _, pid, resident in rows:
        if what == "done":
            memory.setdefault(pid, []).append(int(resident))
    grown = [f"{of[0]} MB after the first chunk, {of[-1]} MB after {len(of)}" for of in memory.values()]
    return lines + [f"worker: {text}" for text in grown]


@contextmanager
def _killing(client: Any, setting: Setting) -> Iterator[list[int]]:
    """Kill a random worker every `kill_every` seconds; yield the list of the killed processes."""
    killed: list[int] = []
    over = threading.Event()

    def kill() -> None:
        rng = random.Random(0)
        while setting.kill_every is not None and not over.wait(setting.kill_every):
            pids = sorted(client.run(os.getpid, on_error="ignore").values())
            if pids and not over.is_set():
                killed.append(rng.choice(pids))
                os.kill(killed[-1], signal.SIGKILL)

    thread = threading.Thread(target=kill, daemon=True)
    thread.start()
    try:
        yield killed
    finally:
        over.set()
        thread.join()


def _start(
    setting: Setting, way: str, *options: str, report: str = "report.json", baking: bool = True
) -> subprocess.Popen:
    """Start bake.py over the jobs file."""
    folder = setting.folder / way
    command = [sys.executable, str(BAKE), "--jobs", "night.jsonl", "--report", str(folder / report), *options]
    command += ["--npz", str(folder / "npz")] if baking else []
    return subprocess.Popen(command, cwd=setting.folder, stdout=subprocess.DEVNULL)


def _check(process: subprocess.Popen) -> None:
    if process.wait() != 0:
        sys.exit(f"{' '.join(map(str, process.args))} has ended with status {process.returncode}")


def _core_seconds() -> float:
    """Return the processor time, seconds, of this process and of its finished child processes."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def hashes(folder: Path) -> dict[str, str]:
    """Return a hash of each take in a folder."""
    import numpy as np

    from .fingerprints import of_arrays

    found = {}
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as data:
            found[path.stem] = of_arrays({name: data[name] for name in data.files})
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--lines", type=int, default=40)
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=WAYS)
    parser.add_argument("--workers", type=int, default=2, help="processes of parts and dask")
    parser.add_argument("--chunk", type=int, default=10, help="lines for each task of openjd and dask")
    parser.add_argument("--kill-every", type=float, help="seconds between two kills of a worker of dask")
    parser.add_argument(
        "--hold", type=float, default=4, help="seconds on the seat; with 4, takes have about ten"
    )
    parser.add_argument("--scene", type=Path, help="room with a Sofa and an Armchair (default: the demo's)")
    parser.add_argument("--folder", type=Path, help="working folder (default: a temporary one)")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = (given.folder or Path(name)).absolute()
        folder.mkdir(parents=True, exist_ok=True)
        prepare(folder, given.lines, given.scene, given.hold)
        setting = Setting(folder, given.lines, given.workers, given.chunk, given.kill_every)
        found, seconds, cores, notes = {}, {}, {}, {}
        for way in given.ways:
            for path in folder.glob("night.jsonl.*done"):
                path.unlink()
            begun, used = time.perf_counter(), _core_seconds()
            notes[way] = globals()[way](setting)
            seconds[way], cores[way] = time.perf_counter() - begun, _core_seconds() - used
        for way in given.ways:
            found[way] = hashes(folder / way / "npz")
    wrong = 0
    first = found[given.ways[0]]
    for way in given.ways:
        same = sum(found[way].get(take) == made for take, made in first.items())
        wrong += len(found[way]) != given.lines or same != len(first)
        speed = f"{given.lines / seconds[way] * 3600:.0f} lines an hour"
        cost = f"{cores[way] / given.lines:.1f} core seconds a line"
        print(
            f"{way}: {len(found[way])} takes, {same} as the first way's, {seconds[way]:.1f} s, {speed}, {cost}"
        )
        print("".join(f"    {note}\n" for note in notes[way]), end="")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
