"""Jobs files on Dask: chunks as tasks of real worker processes, of which some are killed."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
import threading
import time
from collections import Counter

import dask_fakes
import numpy as np
import pytest
from batch_runs import load
from samp_blender.samp_addon.batch import farm
from samp_blender.samp_addon.batch.farm import dask_command
from samp_blender.samp_addon.batch.farm.chunks import Chunk, Work, chunks
from samp_blender.samp_addon.batch.farm.progress_bar import ProgressBar
from samp_blender.samp_addon.errors import UsageError

distributed = pytest.importorskip("distributed", reason="distributed is not installed")
from samp_blender.samp_addon.batch.farm import dask_cluster  # noqa: E402


@pytest.mark.parametrize(
    ("numbers", "size", "expected"),
    [
        ([], 3, []),
        ([1, 2, 3, 4], 2, [Chunk(1, 2, 2), Chunk(3, 4, 2)]),
        ([1, 2, 5, 9, 10], 3, [Chunk(1, 5, 3), Chunk(9, 10, 2)]),
        ([7], 25, [Chunk(7, 7, 1)]),
    ],
)
def test_chunks_have_as_many_lines_that_are_not_empty(numbers, size, expected):
    assert chunks(numbers, size) == expected


@pytest.mark.parametrize(
    ("state", "text"),
    [
        ((0, 0, 0, 0.0), "[------------------------------] 0/40 lines, 0 workers"),
        ((10, 0, 4, 60.0), "[#######-----------------------] 10/40 lines, 4 workers, 3 min left"),
        ((20, 3, 4, 60.0), "[###############---------------] 20/40 lines, 3 failed, 4 workers, 60 s left"),
        ((40, 0, 4, 7200.0), "[##############################] 40/40 lines, 4 workers, 2.0 h"),
    ],
)
def test_progress_bar(state, text):
    assert ProgressBar(40).text(*state) == f"bake: {text}"


@pytest.fixture
def night(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "night.jsonl").write_text('{"action": "idle", "npz": "npz"}\n')
    return tmp_path


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (["--scheduler", "local:0"], "local:4"),
        (["--scheduler", "local:many"], "local:4"),
        (["--scheduler", "local:1", "--chunk", "0"], "--chunk"),
        (["--scheduler", "local:1", "--part", "1/2"], "--part"),
        (["--scheduler", "local:1", "--nonsense"], "--nonsense"),
        (["--scheduler", "tcp://127.0.0.1:9"], "No Dask scheduler answers"),
        ([], "--scheduler"),
    ],
)
def test_wrong_options_are_one_line(night, monkeypatch, capfd, options, reason):
    monkeypatch.setattr(dask_cluster, "CONNECT", 0.5)
    assert dask_command.main(["night.jsonl", *options]) == 2
    complained = [line for line in capfd.readouterr().err.splitlines() if line.startswith("bake:")]
    assert len(complained) == 1 and reason in complained[0]


def test_a_missing_package_is_one_line(night, monkeypatch, capfd):
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, dask_cluster.__name__)
    monkeypatch.delattr(farm, "dask_cluster")
    assert dask_command.main(["night.jsonl", "--scheduler", "local:1"]) == 2
    assert capfd.readouterr().err.count("pip install distributed") == 1


@pytest.fixture
def client():
    """A cluster of one worker with one thread, in this process."""
    options = {"threads_per_worker": 1, "processes": False, "dashboard_address": ":0"}
    with distributed.LocalCluster(n_workers=1, **options) as cluster, distributed.Client(cluster) as made:
        yield made


@pytest.mark.parametrize(("errors", "failed", "lost"), [(0, 2, 0), (2, 2, 0), (3, 4, 2)])
def test_a_chunk_is_submitted_again_after_an_unexpected_error(client, tmp_path, errors, failed, lost):
    work, seen = Work({"errors": errors}, str(tmp_path)), []
    progress = lambda *state: seen.append(state)
    made = dask_cluster.bake_all(client, work, chunks(range(1, 5), 2), 2, progress, dask_fakes.failing)
    assert (made[0], len(made[1])) == (failed, lost)
    assert all(each.reason == "The chunk failed (RuntimeError: no luck)." for each in made[1])
    assert seen[0] == (0, 0, 1) and seen[-1] == (4, failed, 1)


def test_workers_of_this_machine_keep_no_profile():
    with dask_cluster.connected("local:1", ":0") as client:
        callbacks = client.submit(dask_fakes.callbacks).result()
    assert "heartbeat" in callbacks and "profile" not in callbacks


def test_workers_with_several_threads_are_refused(tmp_path):
    options = {"threads_per_worker": 2, "processes": False, "dashboard_address": ":0"}
    with (
        distributed.LocalCluster(n_workers=1, **options) as cluster,
        distributed.Client(cluster) as client,
        pytest.raises(UsageError, match="--nthreads 1"),
    ):
        dask_cluster.bake_all(client, Work({}, str(tmp_path)), chunks([1, 2], 1), 0, bake=dask_fakes.slow)


def test_a_killed_worker_costs_its_running_chunk_only(tmp_path):
    options = {"threads_per_worker": 1, "processes": True, "dashboard_address": ":0"}
    pieces = chunks(range(1, 13), 2)
    with distributed.LocalCluster(n_workers=2, **options) as cluster, distributed.Client(cluster) as client:
        killed = []

        def kill_the_third():
            log = tmp_path / "log"
            while not log.exists() or log.read_text().count("begun") < 3:
                time.sleep(0.02)
            _, chunk, pid = log.read_text().splitlines()[-1].split()
            os.kill(int(pid), signal.SIGKILL)
            killed.append((chunk, pid))

        thread = threading.Thread(target=kill_the_third)
        thread.start()
        made = dask_cluster.bake_all(client, Work({}, str(tmp_path)), pieces, 0, bake=dask_fakes.slow)
        thread.join()
    lines = [line.split() for line in (tmp_path / "log").read_text().splitlines()]
    begun = Counter(name for what, name, _ in lines if what == "begun")
    done = Counter(name for what, name, _ in lines if what == "done")
    assert made == (0, []) and set(done) == {piece.name for piece in pieces}
    ((chunk, pid),) = killed
    # Chunks whose result was lost with the worker are begun again as well; their lines are skipped. On a busy machine
    # the worker may be killed right after the end of its chunk.
    unfetched = {name for what, name, by in lines if what == "done" and by == pid}
    assert begun[chunk] == 2 and done[chunk] == 1 + (chunk in unfetched)
    assert {name for name, count in begun.items() if count > 1} <= {chunk, *unfetched}


def test_takes_of_a_cluster_are_those_of_one_process(room, tmp_path, monkeypatch, capfd):
    """One of two workers dies in its chunk; what it had finished is not made again."""
    scene, start = room
    monkeypatch.chdir(tmp_path)
    shutil.copy(scene, "room.blend")
    shared = {
        "scene": "room.blend",
        "action": "sit",
        "target": "Sofa",
        "start": [float(v) for v in start],
        "hold": 0.5,
    }
    with open("night.jsonl", "w") as file:
        file.write("".join(json.dumps(shared | {"seed": seed}) + "\n" for seed in (1, 2, 3)))
        file.write(json.dumps(shared | {"target": "Nothing"}) + "\n")
    options = ["--scheduler", "local:2", "--chunk", "2", "--dashboard", ":0", "night.jsonl", "--npz", "npz"]
    status = dask_command.main([*options, "--report", "all.json"], dask_fakes.with_fakes_and_a_death)
    said, complained = capfd.readouterr()
    assert status == 1 and (tmp_path / "died").exists()
    assert "bake: Line 4: There is no 'Nothing'" in complained and "4/4 lines, 1 failed" in said
    report = load("all.json")
    assert [(row["line"], row["seed"]) for row in report["variants"]] == [(1, 1), (2, 2), (3, 3)]
    assert [row["line"] for row in report["errors"]] == [4] and len(report["builds"]) == 1
    assert not os.path.exists("all.json.parts") and not list(tmp_path.rglob(".*"))
    entries = (tmp_path / "night.jsonl.lines-1-2.done").read_text().splitlines()
    assert len(entries) == 1  # line 2; line 1 stands in the ledger of the worker that died

    dask_fakes.with_fakes(Work({"jobs": "night.jsonl", "npz": "alone"}, str(tmp_path)), Chunk(1, 3, 3))
    for name in os.listdir("alone"):
        with np.load(f"alone/{name}") as one, np.load(f"npz/{name}") as other:
            assert set(one.files) == set(other.files)
            assert all(one[key].tobytes() == other[key].tobytes() for key in one.files), name
    assert len(os.listdir("alone")) == 3
