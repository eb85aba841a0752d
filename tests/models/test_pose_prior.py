"""The shipped pose prior: rotations of drawn poses, which the places of joints do not show."""

import numpy as np
import pytest
import torch
from samp_blender.models import weights
from samp_blender.models.long_term import layout
from samp_blender.models.long_term.pose_prior import PosePrior
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.skeleton import INDEX

NAME = "long_term_prior"
SPREAD = 0.47
"""Standard deviation of the codes of captured poses."""


@pytest.fixture(scope="module")
def drawn():
    """Local quaternions (1000, 21, 4) of drawn poses."""
    prior = PosePrior().eval()
    weights.fill(prior, weights.load_weights(NAME), weights.weights_path(NAME))
    codes = SPREAD * torch.randn(1000, layout.POSE, generator=torch.Generator().manual_seed(0))
    with torch.no_grad():
        return rotation.matrix_to_quaternion(prior.decode(codes).double().numpy())


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("part, child", [("hip", "knee"), ("knee", "ankle"), ("ankle", "foot")])
def test_no_bone_of_a_leg_is_twisted(drawn, side, part, child):
    """99 % of captured legs twist by less than 35 degrees about each of their bones."""
    joints = human.load().joints
    along = joints[INDEX[f"{side}_{child}"]] - joints[INDEX[f"{side}_{part}"]]
    along /= np.linalg.norm(along)
    turns = drawn[:, INDEX[f"{side}_{part}"] - 1]
    twist = np.degrees(2 * np.arctan2(turns[:, 1:] @ along, turns[:, 0]))
    assert np.percentile(np.abs((twist + 180) % 360 - 180), 99) < 60


def test_an_untrained_prior_returns_poses_near_the_rest_pose():
    """Far from it, a joint may get stuck turned by half a turn."""
    torch.manual_seed(0)
    with torch.no_grad():
        turns = PosePrior().decode(torch.randn(50, layout.POSE))
    cosine = (turns.diagonal(dim1=-2, dim2=-1).sum(-1) - 1) / 2
    assert torch.rad2deg(torch.arccos(cosine.clamp(-1, 1))).max() < 30
