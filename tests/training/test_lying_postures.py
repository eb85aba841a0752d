"""Other ways to lie: on a side, and half sitting against a headboard."""

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.scene import geometry
from samp_blender.training.composition.recline import Recline
from samp_blender.training.fitting.lying import lie_fit, postures
from samp_blender.training.furniture import shapes
from samp_blender.training.mocap.clip_files import Clip
from samp_blender.training.mocap.events import uprightness

MATTRESS = 0.5


@pytest.fixture
def recline():
    """From sitting upright to lying on the back, head towards -Z."""
    count = 60
    back = np.interp(np.arange(count), [0, 40], [0, np.pi / 2])
    quats = np.zeros((count, 22, 4))
    quats[..., 0] = 1
    quats[:, 0] = rotation.from_axis_angle(-back[:, None] * [1.0, 0.0, 0.0])
    root = np.tile([0.0, MATTRESS + 0.11, 0.0], (count, 1))
    feet, bad = np.zeros((count, 2)), np.zeros(count, bool)
    return Recline(Clip("down", root, quats, np.array(["lie"] * count), feet, bad), 45)


@pytest.mark.parametrize("lower, sign", [("left", -1), ("right", 1)])
def test_a_body_on_its_side_has_one_shoulder_up_and_bent_legs(recline, lower, sign):
    made = postures.on_side(recline, lower)
    front, left = lie_fit._facing_up(made.clip)
    assert sign * left[-1] > 0.9 and abs(front[-1]) < 0.4
    assert front[recline.still] > 0.95 and made.still < len(made.clip) - 60
    joints, _ = skeleton.forward_kinematics(
        made.clip.root, made.clip.rotations, skeleton.default_rest_joints()
    )
    assert np.linalg.norm(np.diff(joints, axis=0), axis=-1).max() < 0.1
    # The lower leg and the head stay near the height of the pelvis.
    for name in (f"{lower}_ankle", "head"):
        assert abs(joints[-1, skeleton.INDEX[name], 1] - made.clip.root[-1, 1]) < 0.3
    assert (lie_fit._reclined(made.clip)[recline.still :] > 0.9).all()


def test_a_half_sitting_body_leans_on_the_headboard(recline):
    made = postures.half_sitting(recline)
    upright = uprightness(made.clip)[made.still :]
    np.testing.assert_allclose(upright, postures.HALF, atol=0.08)
    bed = shapes.join([
        shapes.box((-0.5, 0.0, -0.9), (0.5, MATTRESS, 1.0), 12), shapes.box((-0.5, 0.0, -1.0), (0.5, 1.1, -0.9), 12)
    ])  # fmt: skip

    surface = geometry.sample_surface(bed, 20_000, seed=0)[0]
    still = np.arange(len(made.clip)) >= made.still
    back = postures.to_headboard(made.clip, still, surface, MATTRESS, np.array([0.0, 0.0, 1.0]))
    assert 0.2 < back < postures.FARTHEST
    moved = made.clip.root[:, 2] - back
    closer = postures.Clip("", np.column_stack([made.clip.root[:, :2], moved]), made.clip.rotations,
                           made.clip.labels, made.clip.feet, made.clip.bad)  # fmt: skip
    again = postures.to_headboard(closer, still, surface, MATTRESS, np.array([0.0, 0.0, 1.0]))
    assert abs(again) < 0.005
    assert (
        postures.to_headboard(
            made.clip, still, surface[surface[:, 1] < 0.55], MATTRESS, np.array([0, 0, 1.0])
        )
        is None
    )
