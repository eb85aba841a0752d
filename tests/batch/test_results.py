"""Views of a report: the table of all measures, the page with pictures, and previews."""

from __future__ import annotations

import csv
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from samp_blender.samp_addon.batch import main
from samp_blender.samp_addon.batch.results import page, table
from samp_blender.samp_addon.blender.render import workbench

JOB = {
    "scene": "/farm/a <room>.blend",
    "output": None,
    "action": "sit",
    "target": "Sofa",
    "method": "samp",
    "seed": 3,
}
TAKE = {
    "line": 1, "job": JOB, "seed": 3, "method": "samp", "action": "sit", "target": 'Sofa "red"', "frame_end": 200,
    "goal_position": [1, 2, 3], "metrics": {"success": True, "position_error_cm": 1.25, "seated_speed_m_s": None},
    "warnings": ["The body is 7 cm deep.", "It squats & hovers."], "preview": "/farm/out/pictures/a b.png",
}  # fmt: skip
FAILED = {"line": 2, "job": JOB | {"seed": 4}, "message": "There is no 'Sofa'; <choose> another."}
REPORT = {"schema_version": 2, "variants": [TAKE], "errors": [FAILED]}


def test_the_table_has_a_row_for_each_take_and_failure(tmp_path):
    table.write(tmp_path / "t.csv", REPORT)
    with (tmp_path / "t.csv").open(newline="") as file:
        take, failed = csv.DictReader(file)
    assert (take["line"], take["seed"], take["success"], take["position_error_cm"]) == (
        "1",
        "3",
        "True",
        "1.25",
    )
    assert (
        take["scene"] == JOB["scene"] and take["target"] == 'Sofa "red"' and "7 cm deep" in take["warnings"]
    )
    assert (failed["line"], failed["seed"], failed["message"]) == ("2", "4", FAILED["message"])
    assert "goal_position" not in take and list(take)[0] == "line" and list(take)[-1] == "message"


def test_the_table_as_parquet(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    table.write(tmp_path / "t.parquet", REPORT)
    take, failed = parquet.read_table(tmp_path / "t.parquet").to_pylist()
    assert (take["success"], take["position_error_cm"], failed["seed"]) == (True, 1.25, 4)


class Reader(HTMLParser):
    """Collects cells by row, and addresses of pictures."""

    def __init__(self):
        super().__init__()
        self.rows, self.pictures = [], []

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if tag == "tr":
            self.rows.append([])
        if tag == "td":
            self.rows[-1].append(values["data-value"])
        if tag == "img":
            self.pictures.append(values["src"])


def test_the_page_shows_pictures_measures_and_warnings(tmp_path):
    text = page.page(REPORT, tmp_path.__class__("/farm/out"))
    reader = Reader()
    reader.feed(text)
    heads = re.findall(r"<th>(.*?)</th>", text)
    _, take, failed = reader.rows
    assert len(take) == len(failed) == len(heads) and heads[0] == "Preview"
    named = dict(zip(heads, take, strict=True))
    assert (named["Line"], named["Success"], named["Position error, cm"]) == ("1", "1", "1.25")
    assert ">1.2</td>" in text, "rounded for the eye, sorted by the whole number"
    assert named["Target"] == 'Sofa "red"' and "squats & hovers" in named["Warnings"]
    assert dict(zip(heads, failed, strict=True))["Message"] == FAILED["message"]
    assert reader.pictures == ["pictures/a%20b.png"]
    assert "1 take, 1 failed" in text and "<choose>" not in text and "http" not in text


def test_the_page_is_in_the_order_of_the_lines():
    """A failure stands at its line, not behind all takes."""
    reader = Reader()
    report = {"variants": [TAKE | {"line": 3}, TAKE], "errors": [FAILED]}
    reader.feed(page.page(report, Path("/farm/out")))
    assert [row[1] for row in reader.rows[1:]] == ["1", "2", "3"]


@pytest.mark.parametrize(
    ("name", "title"),
    [
        ("foot_slide_cm_s", "Foot slide, cm/s"),
        ("execution_time_s", "Execution time, s"),
        ("rotation_error_deg", "Rotation error, degrees"),
        ("attempts", "Attempts"),
    ],
)
def test_heads_tell_the_unit(name, title):
    assert page._title(name) == title


def test_the_page_sorts():
    """By the script of the page, in a JavaScript engine with a table of three rows."""
    quickjs = pytest.importorskip("quickjs", reason="quickjs is not installed")
    context = quickjs.Context()
    context.eval(
        """
        const cell = (value) => ({ dataset: { value: value } });
        const rows = [["10", "b"], ["9", ""], ["", "a"]].map((row) => ({ cells: row.map(cell) }));
        const tbody = { rows: rows, append: function (...sorted) { this.rows = sorted; } };
        const heads = [0, 1].map((k) => ({
            cellIndex: k, dataset: {}, addEventListener: function (name, act) { this.click = act; } }));
        const document = { querySelectorAll: () => heads, querySelector: () => tbody };
    """
        + page._SCRIPT
    )
    shown = lambda column: context.eval(
        f"heads[{column}].click(); tbody.rows.map((row) => row.cells[{column}].dataset.value).join()"
    )
    assert [shown(0), shown(0), shown(1), shown(1)] == ["9,10,", "10,9,", "a,b,", "b,a,"]


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (["--page", "p.txt"], "--page"),
        (["--table", "t.xls"], "--table"),
        (["--page", "p.html", "--part", "1/2"], "--merge"),
        (["--table", "t.csv", "--lines", "1-2"], "--merge"),
    ],
)
def test_views_that_cannot_be_written(tmp_path, monkeypatch, capfd, options, reason):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "night.jsonl").write_text("{}\n")
    assert main.main(["--jobs", "night.jsonl", *options]) == 2
    assert reason in capfd.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["night.jsonl"]


def test_merging_writes_the_views(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "one.json").write_text(json.dumps(REPORT))
    options = ["--report", "all.json", "--page", "index.html", "--table", "all.csv"]
    assert main.main(["--merge", "one.json", *options]) == 1
    assert (
        "<tbody>" in (tmp_path / "index.html").read_text()
        and (tmp_path / "all.csv").read_text().count("\n") == 3
    )


@pytest.mark.skipif(not workbench.offscreen_works(), reason="no libEGL: pictures cannot be rendered")
def test_previews_of_takes(room, tmp_path, monkeypatch):
    import fakes

    scene, start = room
    monkeypatch.chdir(tmp_path)
    options = [
        "--scene",
        str(scene),
        "--action",
        "sit",
        "--target",
        "Sofa",
        "--start",
        *start,
        "--hold",
        "0.5",
    ]
    options += [
        "--report",
        "r.json",
        "--preview",
        "pictures",
        "--output",
        "out.blend",
        "--page",
        "index.html",
    ]
    assert main.main(options, fakes.TOOLS) == 0
    (variant,) = json.loads((tmp_path / "r.json").read_text())["variants"]
    assert variant["preview"] == str(tmp_path / "pictures" / "room_sit_Sofa_0.png")
    picture = workbench.read_png(variant["preview"]).astype(int)
    assert picture.shape == (480, 480, 3)
    for tile in (picture[:238, :238], picture[-238:, -238:]):
        assert 50 < (abs(tile - tile[0, 0]).max(-1) > 30).sum() < 0.9 * 238**2
    assert 'src="pictures/room_sit_Sofa_0.png"' in (tmp_path / "index.html").read_text()
