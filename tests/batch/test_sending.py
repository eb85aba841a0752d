"""Bundles for a farm: jobs as lines, the files of a bundle, and the settings of each engine."""

from __future__ import annotations

import json
import os
import shlex
import sys
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest
from samp_blender.samp_addon.batch import jobs_file
from samp_blender.samp_addon.batch.farm.sending import bundle, commands, engines, flamenco, lines, sending
from samp_blender.samp_addon.batch.farm.sending.engines import Engine
from samp_blender.samp_addon.batch.order import order
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.methods import registry
from samp_blender.samp_addon.methods.long_term.method import LongTerm
from samp_blender.samp_addon.methods.scene_gan.method import SceneGanMethod
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.pipeline.cast.cast import Cast, Member
from samp_blender.samp_addon.pipeline.job import Job

FILES = {"scene": "scene.blend", "npz": "output/npz"}
SIT = Job("sit", "Sofa, red", seed=7, variants=3, hold=0.0, style=0.0, start=(1.1, -2.0, 1e-7, 90.0))
FAILING = f"{shlex.quote(sys.executable)} -c \"import sys; sys.exit('no such queue')\""
SAT = Job("sit", "Chair", character="Ann", seed=4)


def read(text):
    return order(jobs_file.options(text, {}))


@pytest.fixture(autouse=True)
def _methods(monkeypatch):
    """All methods, whether their weights are there or not."""
    for method in (LongTerm(), SceneGanMethod()):
        monkeypatch.setitem(registry.METHODS, method.name, method)


PLACES = ((0.0, 1.0, 0.0, 90.0), (2.5, 1.0, 0.45, 0.0))
DRAWN = {"camera": "Cam 2", "seconds": 6.0, "draws": 3}


@pytest.mark.parametrize(
    "job",
    [
        lambda: SIT,
        lambda: Job("lie", "-Bed", character="Ann Lee", refine=True, speed=1.25),
        lambda: Job("sit", "Sofa", shape={"height": 1.85, "gender": 0.5}),
        lambda: Job("walk", to=(0.10000000149011612, -3.5, 0.0), via=((1.0, 2.0, 0.0), (-1.0, 2.5, 0.0))),
        lambda: Job(
            "walk", to=(1.0, 2.0, 0.0), then=(Step("sit", "Sofa, red"), Step("run", to=(3.0, 0.0, 0.0, 45.0)))
        ),
        lambda: Job("walk", "Door", then=(Step("lie", "Bed"),), seed=2**31 - 9),
        lambda: Job("", method="scene_gan", settings=DRAWN),
        lambda: Job("", method="long_term", settings={"sub_goals": PLACES, "pause": 0.0}),
        lambda: Job("", method="long_term", character="Ann", then=(Step("sit", "Sofa"),)),
        lambda: Cast(
            (
                Member(SAT, "Ann", 1.5, ("Chair", "Stool"), "Bob"),
                Member(Job("walk", to=(1.0, 2.0, 0.0), seed=4), "Bob"),
            ),
            seed=4,
            variants=2,
        ),
        lambda: Cast(
            (Member(Job("sit", "Sofa", refine=True, hold=1.0, start=(0.0, 1.0, 0.0, 5.0)), "A"),), refine=True
        ),
    ],
)
def test_a_line_gives_the_job_that_it_was_made_of(job):
    made = read(lines.line(job(), FILES))
    assert made.job == job()
    assert (str(made.scene), str(made.npz)) == (FILES["scene"], FILES["npz"])


@pytest.mark.parametrize(
    "job",
    [
        lambda: Job("sit", "Sofa", point=(1.0, 2.0, 0.5)),
        lambda: Job(
            "",
            method="scene_gan",
            settings={"draws": 3},
            then=(Step("", method="scene_gan", settings={"draws": 4}),),
        ),
        lambda: Job("sit", "Sofa", then=(Step("walk", to=(1.0, 2.0, 0.0), via=((1.0, 1.0, 0.0),)),)),
    ],
)
def test_what_a_line_cannot_say_is_refused(job):
    with pytest.raises(SampError, match=r"line of a jobs file"):
        lines.line(job(), FILES)


@pytest.mark.parametrize("job", [SIT, Cast((Member(SAT, "Ann"),), 4)])
def test_the_pieces_of_a_job_have_all_seeds_once(job):
    made = lines.pieces(job, 20, 8)
    assert [seed for piece in made for seed in piece.seeds] == list(range(job.seed, job.seed + 20))
    assert [read(lines.line(piece, FILES)).job for piece in made] == made


@pytest.fixture
def sent(tmp_path):
    """A bundle without an engine."""
    folder = tmp_path / "a bundle"
    folder.mkdir()
    (folder / "scene.blend").write_bytes(b"BLENDER")
    texts = sending.texts([SIT, SAT], 3, 2, blends=True, previews=True)
    sentence = sending.Sending(folder, "room", texts, Engine(), tmp_path).finish(lambda stage, share: None)
    assert str(folder) in sentence
    return bundle.Bundle(folder, "room", folder / "scene.blend", len(texts))


def test_a_bundle_has_what_each_engine_takes(sent):
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    numbered = jobs_file.lines(sent.jobs)
    assert [number for number, _ in numbered] == [1, 2, 3, 4] and sent.count == lines.count(sent.jobs)
    made = [read(text) for _, text in numbered]
    assert [list(each.job.seeds) for each in made] == [[7, 8], [9], [4, 5], [6]]
    assert made[2].output.as_posix() == "output/blend/line_00003.blend" and made[0].preview is not None
    template = yaml.safe_load((sent.folder / "template.yaml").read_text())
    known = {each["name"]: each["type"] for each in template["parameterDefinitions"]}
    values = json.loads((sent.folder / "parameter_values.json").read_text())["parameterValues"]
    assert {each["name"] for each in values} == set(known)
    assert {each["name"]: each["value"] for each in values}["Lines"] == 4
    assets = json.loads((sent.folder / "asset_references.json").read_text())["assetReferences"]
    assert assets["inputs"]["filenames"] == [str(sent.scene)]


def test_flamenco_gets_the_settings_of_its_job_type(sent):
    quickjs = pytest.importorskip("quickjs", reason="quickjs is not installed")
    context = quickjs.Context()
    context.eval((bundle.TEMPLATE.parents[1] / "flamenco" / "samp_bake.js").read_text(encoding="utf-8"))
    wanted = json.loads(context.eval("JSON.stringify(JOB_TYPE.settings)"))
    job = json.loads((sent.folder / "flamenco.json").read_text())
    assert set(job["settings"]) == {each["key"] for each in wanted}
    kinds = {"string": str, "int32": int}
    assert all(isinstance(job["settings"][each["key"]], kinds[each["type"]]) for each in wanted)


def test_an_own_command_gets_its_words(sent, tmp_path):
    record = tmp_path / "words.json"
    program = f"import json, sys; json.dump(sys.argv[1:], open({str(record)!r}, 'w')); print('job 12')"
    rest = "{jobs} --out={output} {lines} '{x}' \"{name} 1\""
    line = f"{shlex.quote(sys.executable)} -c {shlex.quote(program)} {rest}"
    assert engines.submit(Engine("COMMAND", line), sent) == "Sent 4 jobs: job 12"
    words = [str(sent.jobs), f"--out={sent.output}", "4", "{x}", "room 1"]
    assert json.loads(record.read_text()) == words
    assert (sent.folder / commands.LOG).read_text().strip() == "job 12"


@pytest.mark.parametrize(
    ("engine", "reason"),
    [
        (Engine("COMMAND", "no-such-program-here {jobs}"), "There is no program 'no-such-program-here'"),
        (Engine("COMMAND", FAILING), "status 1: no such queue"),
        (Engine("DASK", scheduler="local:1", python=f"{os.devnull}"), "cannot be started"),
        (Engine("FLAMENCO", manager="http://127.0.0.1:1"), "cannot be reached"),
    ],
)  # fmt: skip
def test_a_submission_that_fails_says_why(sent, engine, reason):
    with pytest.raises(SampError) as caught:
        engines.submit(engine, sent)
    assert reason in str(caught.value) and "\n" not in str(caught.value)
    assert sent.jobs.is_file()


def test_a_submission_can_be_cancelled(sent):
    class Enough(Exception):
        pass

    def stop(stage, share):
        raise Enough

    with pytest.raises(Enough):
        commands.run([sys.executable, "-c", "import time; time.sleep(60)"], sent.folder, stop)


@pytest.mark.parametrize(
    ("engine", "reason"),
    [
        (Engine("SLURM"), "There is no engine"),
        (Engine("COMMAND", " "), "no command line"),
        (Engine("COMMAND", "send 'it"), "cannot be read"),
        (Engine("DASK", scheduler="local:1"), "Dask needs"),
        (Engine("FLAMENCO", manager="farm:8080"), "no address"),
        (Engine("FLAMENCO"), "online access is off"),
    ],
)
def test_engines_that_are_not_set_up(engine, reason):
    with pytest.raises(SampError, match=reason):
        engines.check(engine, online=False)


class Manager(BaseHTTPRequestHandler):
    """Stands for Flamenco's manager: the two calls of its API that are used."""

    known = True
    posted: list = []

    def do_GET(self):
        if self.known and self.path == "/api/v3/jobs/type/samp-bake":
            return self._answer(200, {"name": "samp-bake", "etag": "v1"})
        return self._answer(404, {"code": 404, "message": "no such job type"})

    def do_POST(self):
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.posted.append((self.path, self.headers["Content-Type"], body))
        if body["settings"]["lines"] > 100:
            return self._answer(422, {"code": 422, "message": "too many lines"})
        return self._answer(200, {"id": "42", "status": "queued"} | body)

    def _answer(self, status, content):
        self.send_response(status)
        self.end_headers()
        self.wfile.write(json.dumps(content).encode())

    def log_message(self, *arguments):
        pass


@pytest.fixture
def manager():
    server = HTTPServer(("127.0.0.1", 0), type("Own", (Manager,), {"posted": []}))
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield server
    server.shutdown()
    server.server_close()


def test_flamencos_api(sent, manager):
    address = f"http://127.0.0.1:{manager.server_port}/"
    assert engines.submit(Engine("FLAMENCO", manager=address), sent) == "Sent 4 jobs to Flamenco as job 42."
    ((path, kind, job),) = manager.RequestHandlerClass.posted
    assert (path, kind, job["type_etag"]) == ("/api/v3/jobs", "application/json", "v1")
    assert job["settings"]["jobs_file"] == Path(sent.jobs).as_posix()
    many = bundle.flamenco_job(sent, Engine().workers)
    many["settings"]["lines"] = 101
    with pytest.raises(SampError, match=r"refused the job \(422: too many lines\)"):
        flamenco.post(address, many)
    manager.RequestHandlerClass.known = False
    with pytest.raises(SampError, match="has no job type 'samp-bake'"):
        flamenco.post(address, many)
