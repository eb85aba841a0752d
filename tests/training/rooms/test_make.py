"""A room from clips, pieces and uses, end to end: all stages, the same again after being killed."""

import shutil

import numpy as np
import pytest
from room_clips import small_bank
from samp_blender.training.furniture import shapes
from samp_blender.training.rooms import make
from samp_blender.training.rooms.classes import Part
from samp_blender.training.rooms.corpus import store
from samp_blender.training.rooms.corpus.room_builder import RoomBuilder, entry
from samp_blender.training.rooms.episodes import composer, matching
from samp_blender.training.rooms.episodes.search import Search
from samp_blender.training.rooms.layout.stock import Item, Stock
from samp_blender.training.rooms.uses import use as uses

from .test_uses import SEAT, sitting_clip

NUMBER = 5  # a waiting room: seats along the walls


class StoolUses:
    """The sit of a synthetic clip on every item."""

    def of(self, item):
        use = uses.in_frame(sitting_clip(), (0.0, 0.0, 0.0), "sit", 0, (30, 50, 109, 129), None)
        return uses.with_rises([use])


@pytest.fixture
def builder(tmp_path):
    box = shapes.box((-0.2, 0.0, -0.2), (0.2, SEAT, 0.1), 4)
    items = [Item(f"box_{c}", c, [Part("chair", box)]) for c in ("chair", "bench")]
    bank = small_bank()
    stocks = {"train": Stock(items), "test": Stock(items)}
    return RoomBuilder(tmp_path, 0, stocks, bank, Search(bank), StoolUses(), episodes=2)


def arrays(folder, stage):
    return {path.stem: np.load(path) for path in (folder / stage).glob("*.npy")}


def test_a_room_is_made_and_continued(builder, tmp_path, monkeypatch):
    pytest.importorskip("embreex")
    # The few gliding clips cannot end everywhere in every direction.
    for name, value in (("ARRIVED", 0.5), ("FACED", 3.2), ("STILL", 0.6), ("PATIENCE", 6.0)):
        monkeypatch.setattr(matching, name, value)
    for name, value in (("FARTHEST", 1.5), ("WIDEST", 3.2)):
        monkeypatch.setattr(composer, name, value)
    made = builder.make(NUMBER, "train", 1)
    assert made["episodes"] == 2, made["report"]
    assert made["pictures"] == 1 and made["sits"] > 0
    assert made == entry(tmp_path, NUMBER, "train")
    folder = store.room_folder(tmp_path, NUMBER)
    before = {stage: arrays(folder, stage) for stage in ("cloud", "motion", "pictures")}
    data = store.RoomData(folder)
    assert data.array("pictures", "colour").shape == (1, 144, 256, 3)
    in_use = data.array("motion", "objects") >= 0
    assert in_use.any() and set(data.array("motion", "objects")[in_use]) <= set(data.room.seats)
    # Killed after the layout: what follows is the same again.
    for stage in before:
        shutil.rmtree(folder / stage)
    assert entry(tmp_path, NUMBER, "train") is None
    builder.make(NUMBER, "train", 1)
    for stage, found in before.items():
        for name, values in arrays(folder, stage).items():
            np.testing.assert_array_equal(values, found[name], err_msg=f"{stage} {name}")


def test_every_fifth_room_is_for_testing_and_pictures_are_shared_out():
    splits = [make.split_of(k) for k in range(300)]
    assert splits.count("train") == 240 and splits.count("test") == 60
    assert make.pictures_of("train", 300, 1.0) == 50 and make.pictures_of("test", 300, 0.5) == 17


def test_a_room_that_fails_is_named_and_the_others_go_on(monkeypatch, capsys):
    class Broken:
        def make(self, number, split, pictures):
            if number == 1:
                raise ValueError("no floor")
            return {"number": number, "split": split, "kind": "cafe", "episodes": 2, "sits": 1, "lies": 0,
                    "pictures": pictures}  # fmt: skip

    monkeypatch.setattr(make, "_room_builder", Broken(), raising=False)
    made = [room and room["number"] for room in make._rooms([(k, "train", 0) for k in range(3)], workers=1)]
    assert made == [0, None, 2]
    assert "room 1 train failed" in (out := capsys.readouterr().out) and "no floor" in out
