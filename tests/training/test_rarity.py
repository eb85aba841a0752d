"""Rare postures are trained more often, within a limit."""

import numpy as np
from samp_blender.samp_addon.vocabulary import POSTURE_NAMES
from samp_blender.training.samp.motion_net.learning import rarity


def rows(*names: str) -> np.ndarray:
    return np.array([[name == other for other in POSTURE_NAMES] for name in names], np.float32)


def test_rare_postures_weigh_more() -> None:
    postures = rows(*["on_back"] * 18, "on_side", "on_side", "upright")
    kinds = np.array(["lie"] * 20 + ["sit"])
    weight = rarity.weights(postures, kinds)
    assert np.allclose(weight[:18], 1) and np.allclose(weight[18:20], 2)
    assert weight[20] == 1


def test_weights_have_a_limit_and_unknown_postures_have_none() -> None:
    postures = np.concatenate([rows(*["on_back"] * 999, "half_sitting"), np.zeros((1, len(POSTURE_NAMES)))])
    weight = rarity.weights(postures, np.array(["lie"] * 1000 + ["walk"]))
    assert weight[999] == rarity.LARGEST and weight[1000] == 1
