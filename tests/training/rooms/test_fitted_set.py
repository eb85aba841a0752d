"""Uses from a file of fitted sits: labels, one use for each sit, rises by reversal, holds there and back."""

from dataclasses import replace

import numpy as np
import pytest
from samp_blender.training.composition.sequence import Sequence, save
from samp_blender.training.fitting.shapes.piece_file import write_pieces
from samp_blender.training.fitting.shapes.pieces import FittingPiece
from samp_blender.training.furniture import shapes
from samp_blender.training.rooms.classes import Part
from samp_blender.training.rooms.episodes import composer
from samp_blender.training.rooms.episodes.bank import LABELS
from samp_blender.training.rooms.layout.stock import Item
from samp_blender.training.rooms.uses import fitted_set
from samp_blender.training.rooms.uses import use as uses

NAMES = np.array(LABELS)
BOX = shapes.box((-0.2, 0.0, -0.2), (0.2, 0.45, 0.2), 4)


def sitting(shift=0.0, lies=False):
    """A sequence that walks, sits or lies down, rests, and gets up again."""
    going, resting, rising = ("lie_down", "lie", "get_up") if lies else ("sit_down", "sit", "stand_up")
    labels = np.array(["walk"] * 60 + [going] * 20 + [resting] * 40 + [rising] * 20 + ["idle"] * 30)
    count = len(labels)
    down = np.interp(np.arange(count), [60, 80, 120, 140], [0, 1, 1, 0])
    root = np.column_stack([np.zeros(count), 0.93 - 0.3 * down, np.linspace(1.5, shift, count)])
    quats = np.zeros((count, 22, 4))
    quats[..., 0] = 1
    goal = np.tile([shift, 0.63, 0.0, 0.0, 0.0, 1.0], (count, 1))
    return Sequence(
        "lie" if lies else "sit", root, quats, labels, np.ones((count, 2)), np.zeros(count, bool), goal,
        np.full(count, 4 if lies else 3), piece=0, placement=(0.0, 0.0, 0.0),
    )  # fmt: skip


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "fitted.npz"
    twice = [sitting(), sitting(), sitting(0.2)]  # the second differs from the first in its approach only
    save(path, twice, {"centres": np.zeros((1, 512, 3)), "occupancy": np.zeros((1, 512))}, mirrored=True)
    write_pieces(path, [FittingPiece(0, "pouf", "pouf_0", BOX)])
    return path


@pytest.mark.parametrize("lies", [False, True])
def test_labels_are_read_from_actions_contacts_and_heights(lies):
    made = sitting(lies=lies)
    labels = fitted_set.labelled(made.action_weights(), made.contacts()[:, 0] > 0.5, made.root[:, 1])
    assert (labels == made.labels).mean() > 0.9
    for name in set(made.labels):
        assert abs(int(np.argmax(labels == name)) - int(np.argmax(made.labels == name))) < 9, name


def test_each_sit_is_one_use(file):
    made = fitted_set.sits_and_lies(file)
    assert len(made) == 2
    use = uses.of_sequence(made[0], 0, fitted=True)
    assert use.action == "sit" and use.down < use.seated < use.seat_end < use.up_end
    assert use.fitted and (use.source == -1).all()


def test_items_of_the_file_have_its_uses_and_others_those_of_the_rest(file, bank_of):
    found = fitted_set.FittedSet([file], bank_of(sitting()))
    (item,) = found.used_items()
    assert item.category == "pouf" and len(found.of(item)) == 2
    assert found.of(replace(item, name="other")) == []
    # Arms and head are those of the bank's only clip, so its frames are found again.
    assert (found.of(item)[0].source >= 0).mean() > 0.5


@pytest.mark.parametrize("category, place, kept", [("stool", 0.0, 0), ("stool", 0.8, 1), ("pouf", 0.0, 1)])
def test_uses_deep_in_hard_furniture_are_dropped(category, place, kept):
    # The body stands upright with its legs in the box, or beside it.
    use = uses.of_sequence(sitting(), 0)
    use = replace(use, root=use.root * [1.0, 1.0, 0.0] + [place, 0.0, 0.0])
    assert len(uses.sound([use], Item("box", category, [Part("chair", BOX)]))) == kept


@pytest.fixture
def bank_of():
    class Bank:
        def __init__(self, sequence):
            self.rotations = sequence.rotations.astype(np.float32)
            self.clip = np.zeros(len(sequence), int)

    return Bank


def test_a_way_down_is_played_backwards_as_a_rise():
    whole = uses.of_sequence(sitting(), 0)
    ends_seated = replace(whole, up_end=-1)
    added = uses.with_rises([whole, ends_seated])
    assert len(added) == 3
    rise = added[2]
    names = NAMES[rise.labels]
    assert rise.down == -1 and names[0] == "sit" and "stand_up" in names and names[-1] == "walk"
    assert NAMES[rise.labels[rise.seat_end]] == "sit" and NAMES[rise.labels[rise.up_end]] == "stand_up"
    np.testing.assert_allclose(rise.root[rise.seat_end], whole.root[whole.seated])
    assert uses.reversed_rise(replace(whole, down=-1)) is None


@pytest.mark.parametrize("hold, longest", [(30, 0), (100, 90), (300, 290)])
def test_short_holds_are_played_there_and_back(hold, longest):
    use = uses.of_sequence(sitting(), 0)
    end = use.seat_end
    frames = composer.there_and_back(use, end, hold)
    assert len(frames) <= longest + 60
    if longest:
        assert len(frames) > 30 and np.abs(np.diff(np.concatenate([[end], frames]))).max() == 1
        assert frames[-1] == end and frames.min() > use.seated
    else:
        assert len(frames) == 0


def test_steady_matches_fill_gaps_of_one_clip():
    clip = np.zeros(100, int)
    found = np.array([10, -1, -1, 13, 40, -1, 42])
    np.testing.assert_array_equal(fitted_set._steady(found, clip), [10, 11, 12, 13, 40, 41, 42])
    clip[12:] = 1
    assert fitted_set._steady(found, clip)[1] == -1
