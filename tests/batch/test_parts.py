"""A jobs file in parts: which lines a part has, what it may write, and the joined report. Baking is a fake."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import signal
import sys
import time

import pytest
from samp_blender.samp_addon.batch import main, many, memory
from samp_blender.samp_addon.batch.carry_out import Outcome
from samp_blender.samp_addon.batch.farm import selection


@pytest.fixture
def night(tmp_path, monkeypatch):
    """A folder with a scene, in which jobs files are run; `baked` has what was baked, in order."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.blend").write_bytes(b"a scene")
    baked = []

    def carry_out(made, tools, console, saved=None, place=None):
        if made.job.target == "Broken":
            return Outcome(errors=[{"message": "It broke."}])
        baked.append(made.job.seed)
        files = [made.output] if made.output else list(made.npz_paths().values())
        for path in files:
            path.parent.mkdir(exist_ok=True)
            path.write_text("a take")
        return Outcome([{"seed": seed, "target": made.job.target} for seed in made.job.seeds], [], files)

    monkeypatch.setattr(many, "carry_out", carry_out)
    return baked


def write_jobs(*lines):
    shared = {"scene": "room.blend", "action": "sit", "target": "Sofa"}
    text = [line if isinstance(line, str) else json.dumps(shared | line) for line in lines]
    with open("night.jsonl", "w") as file:
        file.write("\n".join(text))


def run(*options):
    return main.main(["--jobs", "night.jsonl", *map(str, options)])


def load(name):
    with open(name) as file:
        return json.load(file)


def rows(report):
    return [
        (row["line"], row.get("seed"), row.get("message"))
        for kind in ("variants", "errors")
        for row in report[kind]
    ]


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("0/3", [3, 6, 9]),
        ("1/3", [1, 4, 7]),
        ("2/3", [2, 5, 8]),
        ("3/3", [3, 6, 9]),
        ("1/1", list(range(1, 10))),
        ("9/20", [9]),
        ("15/20", []),
    ],
)
def test_lines_of_a_part(text, numbers):
    assert [number for number in range(1, 10) if number in selection.part(text)] == numbers


@pytest.mark.parametrize(
    "made", [selection.part("2/7"), selection.part("7/7"), selection.span("3-25"), selection.span("4")]
)
def test_a_selection_is_known_by_its_name(made):
    assert selection.named(made.name) == made


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (["--part", "4/3"], "I/N with I from 0 to N"),
        (["--part", "0/0"], "I/N"),
        (["--part", "-1/3"], "--part"),
        (["--part", "1"], "I/N"),
        (["--part", "1/2/3"], "I/N"),
        (["--part", "a/b"], "I/N"),
        (["--part", "1/2", "--lines", "1-2"], "not both"),
        (["--lines", "0-2"], "first line is 1"),
        (["--lines", "3-2"], "FIRST-LAST"),
        (["--lines", "x"], "FIRST-LAST"),
        (["--on-failure", "ignore"], "--on-failure"),
        (["--progress", "magic"], "--progress"),
        (["--relative-to", "nowhere"], "nowhere"),
        (["--merge", "one.json"], "--report"),
        (["--merge", "one.json", "--report", "all.json"], "no report 'one.json'"),
        (["--merge", "night.jsonl", "--report", "all.json"], "no report of this version"),
        (["--merge", "night.jsonl", "--report", "all.json", "--part", "1/2"], "leave out --part"),
        (["--merge", "night.jsonl", "--report", "all.json", "--npz", "npz"], "leave out --npz"),
    ],
)
def test_wrong_options_are_one_line(night, capfd, options, reason):
    write_jobs({"npz": "npz"})
    assert run(*options) == 2
    complained = capfd.readouterr().err
    assert reason in complained and complained.count("\n") == 1
    assert sorted(os.listdir()) == ["night.jsonl", "room.blend"]


@pytest.mark.parametrize("option", ["--part=1/2", "--lines=1", "--on-failure=report", "--relative-to=."])
def test_parts_are_for_jobs_files(night, capfd, option):
    assert main.main(["--scene", "room.blend", "--action", "idle", "--npz", "npz", option]) == 2
    assert "--jobs" in capfd.readouterr().err


JOBS = [
    {"npz": "npz", "seed": 1},
    {"output": "two.blend", "seed": 2},
    "",
    {"npz": "npz", "seed": 4, "variants": 2},
    "{not json",
    {"npz": "npz", "seed": 6, "target": "Broken"},
    {"npz": "npz", "seed": 7},
    {"npz": "npz", "seed": 1},
    {"output": "two.blend", "seed": 9},
]


@pytest.mark.parametrize(
    "pieces",
    [
        [["--part", f"{k}/1"] for k in (0,)],
        [["--part", f"{k}/2"] for k in (0, 1)],
        [["--part", f"{k}/3"] for k in (3, 1, 2)],
        [["--part", f"{k}/20"] for k in range(20)],
        [["--lines", lines] for lines in ("6-100", "1-5")],
        [["--lines", lines] for lines in ("8", "9", "1-7")],
    ],
)
def test_joined_parts_give_the_report_of_one_run(night, pieces):
    write_jobs(*JOBS)
    assert run("--report", "whole.json") == 1
    whole, alone = load("whole.json"), list(night)
    for name in ("night.jsonl.done", "two.blend"):
        os.unlink(name)
    night.clear()
    for count, piece in enumerate(pieces):
        assert run(*piece, "--report", f"parts/{count}.json") in (0, 1)
    assert sorted(night) == sorted(alone)
    assert run("--merge", "parts", "--report", "all.json") == 1
    assert load("all.json") == whole
    assert rows(whole) == [
        (1, 1, None), (2, 2, None), (4, 4, None), (4, 5, None), (7, 7, None), (8, 1, None),
        (5, None, "This is not JSON (Expecting property name enclosed in double quotes at column 2)."),
        (6, None, "It broke."),
        (9, None, f"'{os.path.abspath('two.blend')}' is written by line 2 already; name another file."),
    ]  # fmt: skip


@pytest.mark.parametrize(
    "again", [["--part", "1/2"], ["--part", "1/4"], ["--part", "3/4"], ["--lines", "1-9"], []]
)
def test_a_second_run_skips_what_any_part_has_done(night, again):
    write_jobs(*JOBS)
    for piece in ("0/2", "1/2"):
        run("--part", piece)
    night.clear()
    run(*again)
    assert night == []


def test_a_changed_line_is_done_again_by_its_part_only(night):
    write_jobs(*({"npz": "npz", "seed": seed} for seed in (1, 2, 3, 4)))
    for piece in ("0/2", "1/2"):
        run("--part", piece)
    night.clear()
    write_jobs(*({"npz": "npz", "seed": seed} for seed in (1, 2, 30, 4)))
    assert [run("--part", piece) for piece in ("0/2", "1/2")] == [0, 0]
    assert night == [30]


def test_no_two_parts_write_the_same_file(night, monkeypatch):
    """Except the folders of takes of unfinished jobs, whose files have the job's name."""
    write_jobs(*({"npz": "npz", "seed": seed} for seed in (1, 2, 3, 4)))
    written = []
    for piece in ("0/2", "1/2"):
        before = {path: path.stat().st_mtime_ns for path in files()}
        run("--part", piece, "--report", f"{piece[0]}.json")
        written.append({path for path in files() if before.get(path) != path.stat().st_mtime_ns})
    assert not written[0] & written[1]
    assert {path.name for path in written[1]} == {
        "1.json", "night.jsonl.part-1-of-2.done", "room_sit_Sofa_1.npz", "room_sit_Sofa_3.npz",
    }  # fmt: skip


def files():
    from pathlib import Path

    return [path for path in Path().rglob("*") if path.is_file()]


def test_the_report_of_another_part_is_not_written_over(night, capfd):
    write_jobs(*JOBS[:2])
    assert run("--part", "1/2", "--report", "same.json") == 0
    kept = load("same.json")
    assert run("--part", "2/2", "--report", "same.json") == 2
    assert "same.json' is the report of part-1-of-2" in capfd.readouterr().err
    assert load("same.json") == kept and night == [1]
    assert run("--part", "1/2", "--report", "same.json") == 0


def test_lines_with_the_same_report_collide(night):
    write_jobs({"npz": "a", "seed": 1, "report": "r.json"}, {"npz": "b", "seed": 2, "report": "r.json"})
    assert run("--part", "2/2", "--report", "two.json") == 1
    assert night == [] and "written by line 1" in load("two.json")["errors"][0]["message"]
    assert run("--part", "1/2") == 0
    assert [row["seed"] for row in load("r.json")["variants"]] == [1]


def test_a_line_that_cannot_be_done_claims_nothing(night):
    write_jobs({"output": "a.blend", "scene": "nowhere.blend"}, {"output": "a.blend", "seed": 2})
    assert run("--part", "2/2") == 0 and night == [2]


@pytest.mark.parametrize(
    ("option", "status"), [([], 1), (["--on-failure", "fail"], 1), (["--on-failure", "report"], 0)]
)
def test_status_where_a_line_fails(night, option, status):
    write_jobs({"npz": "npz", "target": "Broken"})
    assert run(*option, "--report", "r.json") == status
    assert run("--merge", "r.json", *option, "--report", "all.json") == status
    assert load("all.json")["errors"][0]["message"] == "It broke."


def test_merging_with_the_jobs_file_shows_lines_without_a_report(night, capfd):
    write_jobs(*({"npz": "npz", "seed": seed} for seed in (1, 2, 3)))
    run("--lines", "1-2", "--report", "a.json")
    assert run("--merge", "a.json", "--report", "all.json") == 1
    assert rows(load("all.json"))[2:] == [(3, None, "This line is in no report; run its part.")]
    assert main.main(["--merge", "a.json", "--report", "all.json"]) == 0
    assert capfd.readouterr().err == ""


def test_of_several_results_of_a_line_the_done_one_counts(night):
    write_jobs({"npz": "npz", "target": "Broken"}, {"npz": "npz"})
    run("--lines", "1", "--report", "old.json")
    write_jobs({"npz": "npz", "seed": 5}, {"npz": "npz"})
    time.sleep(0.01)
    run("--lines", "1-2", "--report", "new.json")
    for order in itertools.permutations(("old.json", "new.json")):
        assert run("--merge", *order, "--report", "all.json") == 0
        assert rows(load("all.json")) == [(1, 5, None), (2, 0, None)]


def test_different_builds_are_reported(night, capfd):
    write_jobs(*JOBS[:2])
    for piece in ("1", "2"):
        run("--lines", piece, "--report", f"{piece}.json")
    other = load("2.json")
    other["builds"][0]["torch"] = "0.1"
    with open("2.json", "w") as file:
        json.dump(other, file)
    assert run("--merge", "1.json", "2.json", "--report", "all.json") == 0
    assert "2 different builds" in capfd.readouterr().err
    builds = load("all.json")["builds"]
    assert len(builds) == 2 and set(builds[0]["weights"]) >= {"goal_net", "motion_net"}


def test_relative_names_begin_in_the_given_folder(night, tmp_path, monkeypatch):
    write_jobs({"npz": "npz", "seed": 3})
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    options = ["--jobs", "../night.jsonl", "--relative-to", "../night.jsonl", "--report", "r.json"]
    assert main.main(options) == 0
    assert (tmp_path / "npz" / "room_sit_Sofa_3.npz").is_file() and (elsewhere / "r.json").is_file()


def test_progress_for_open_job_description(night, capfd):
    write_jobs({"npz": "npz"}, {"npz": "npz", "target": "Broken"})
    assert run("--progress", "openjd") == 1
    said = capfd.readouterr().out.splitlines()
    assert [line for line in said if line.startswith("openjd_progress")] == [
        "openjd_progress: 0.0", "openjd_progress: 50.0", "openjd_progress: 100.0",
    ]  # fmt: skip
    assert "openjd_status: 2/2 line 2" in said and said[-1] == "openjd_fail: Line 2: It broke."
    assert "openjd" not in "".join(line for line in said if line.startswith("bake:"))


def test_a_large_jobs_file_is_not_parsed_as_a_whole(night, monkeypatch):
    """A part parses its own lines, and of the others only those that may write the same file."""
    write_jobs(*({"npz": f"npz{number // 3}", "seed": number} for number in range(600)))
    parsed = []
    options = many.jobs_file.options
    monkeypatch.setattr(
        many.jobs_file, "options", lambda text, shared: parsed.append(text) or options(text, shared)
    )
    assert run("--lines", "301-302") == 0
    assert len(night) == 2 and len(parsed) <= 4


def test_a_stop_is_not_lost_where_blender_drops_the_exception(night, monkeypatch, capfd):
    write_jobs(*({"npz": "npz", "seed": seed} for seed in (1, 2, 3)))
    carry_out = many.carry_out

    def dropping(made, *arguments):
        with contextlib.suppress(KeyboardInterrupt):
            if made.job.seed == 2:
                signal.raise_signal(signal.SIGTERM)
        return carry_out(made, *arguments)

    monkeypatch.setattr(many, "carry_out", dropping)
    before = signal.getsignal(signal.SIGTERM)
    assert run("--report", "r.json", "--on-failure", "report") == 1
    assert capfd.readouterr().err == "bake: Stopped.\n" and night == [1, 2]
    assert signal.getsignal(signal.SIGTERM) is before
    monkeypatch.setattr(many, "carry_out", carry_out)
    assert run("--report", "r.json") == 0 and night == [1, 2, 3]


def test_memory_is_given_back_after_each_line(night, monkeypatch):
    after = []
    monkeypatch.setattr(memory, "give_back", lambda: after.append(len(night)))
    write_jobs({"seed": 1}, {"seed": 2}, {"seed": 3})
    run("--npz", "npz")
    assert after == [1, 2, 3]


def test_the_holes_between_what_is_kept_are_given_back():
    if not sys.platform.startswith("linux") or memory._trim()(0) is None:
        pytest.skip("only glibc keeps them and can give them back")
    blocks = [b"x" * 100_000 for _ in range(2000)]
    del blocks[::2]
    before = resident()
    memory.give_back()
    assert before - resident() > 50
    assert len(blocks) == 1000


def resident():
    """The process's memory, MB."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
