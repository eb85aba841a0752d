"""What a job says of hands, and where it can be said."""

from __future__ import annotations

import json

import pytest
from samp_blender.samp_addon.batch import command_line, jobs_file
from samp_blender.samp_addon.batch.order import order
from samp_blender.samp_addon.errors import UsageError
from samp_blender.samp_addon.pipeline.hand_request import HandRequest, parse
from samp_blender.samp_addon.pipeline.job import Job


@pytest.mark.parametrize(
    ("text", "request_"),
    [
        ("left=Table", HandRequest("left", "Table")),
        ("right=Cup:40-90", HandRequest("right", "Cup", None, 40, 90)),
        ("right=Cup:-5-90", HandRequest("right", "Cup", None, -5, 90)),
        ("left=Set/Table.001#12", HandRequest("left", "Set/Table.001", 12)),
        ("left=Arm rest: left#3:1-9", HandRequest("left", "Arm rest: left", 3, 1, 9)),
    ],
)
def test_texts(text, request_):
    assert parse(text) == request_


@pytest.mark.parametrize("text", ["", "Table", "both=Table", "left=", "left=Cup:9-4", 3])
def test_other_texts_are_refused(text):
    with pytest.raises(UsageError, match="--hand"):
        parse(text)
    with pytest.raises(UsageError):
        Job(target="Sofa", hand=(text,))


def test_the_command_line_and_a_jobs_file_say_the_same():
    hands = ["left=Table", "right=Cup:40-90"]
    words = ["--action", "sit", "--target", "Sofa", "--report", "r.json"]
    made = order(command_line.parse([*words, *(word for hand in hands for word in ("--hand", hand))]))
    line = {"action": "sit", "target": "Sofa", "report": "r.json", "hand": hands}
    assert made == order(jobs_file.options(json.dumps(line), {}))
    assert made.job.hand == tuple(hands) and made.options()["hand"] == hands
    assert "hand" not in order(command_line.parse(words)).options()
