"""The .npz format of collected public conversions: local rotations on the skeleton of the conversion.

Keys: root_pos (T, 3) metres, local_quat_xyzw (T, J, 4), offsets (J, 3), parents, names, fps, and label (T,) into
label_names. Y up, +Z forward; the zero pose is a T-pose.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ....samp_addon import rotation
from ....samp_addon.easing import smoothstep
from ....samp_addon.errors import SampError
from ..recording import Recording, of_local

KEYS = ("root_pos", "local_quat_xyzw", "offsets", "parents", "names", "fps")
LEGS = (("lThigh", "lShin", "lFoot"), ("rThigh", "rShin", "rFoot"))
ARMS = (("lShldr", "lForeArm", "lHand"), ("rShldr", "rForeArm", "rHand"))
"""Limbs of the figure onto which the CMU database was converted.

The figure's zero pose has 10 degrees in the knee and 17 in the elbow, but the conversion equated it with the straight
limbs of the ASF skeleton: its local rotations are the angles of the AMC file (02_01: 0 to 3 degrees apart in knees and
elbows; by the joints' positions, 9 and 17). Taken from its joints' positions, every motion is a crouch. Its feet,
however, are steadier unchanged than on straight legs (0.4 against 0.6 cm of vertical motion within stances), and clear
the floor.
"""

SEATED, UPRIGHT = 0.7, 0.88  # height of the hips over the lower ankle, in leg lengths


def read(path: Path) -> Recording:
    """Return the motion of a file. Raise SampError where keys are missing.

    On the figure of the CMU conversion, limbs are straightened in the rest pose, feet stay, and the hips are raised
    until the straighter leg has the flexion of its knee's rotation.
    """
    with np.load(path) as data:
        missing = [key for key in KEYS if key not in data]
        if missing:
            raise SampError(f"'{path.name}' lacks {', '.join(missing)}.")
        names = [str(name) for name in data["names"]]
        offsets = data["offsets"].astype(np.float64)
        local = rotation.normalise(data["local_quat_xyzw"].astype(np.float64))[..., [3, 0, 1, 2]]
        root = data["root_pos"].astype(np.float64)
        labels = data["label_names"][data["label"]].astype(str) if "label" in data else None
        fps, parents = float(data["fps"]), data["parents"].astype(int)

    def posed(bones: np.ndarray) -> Recording:
        moved = np.tile(bones, (len(root), 1, 1))
        moved[:, 0] = root
        return of_local(path.stem, fps, names, parents, bones, local, moved, labels=labels)

    captured = posed(offsets)
    if not {joint for limb in LEGS + ARMS for joint in limb} <= set(names):
        return captured
    straight = posed(straightened(offsets, names))
    return replace(straight, positions=_raised(captured, straight))


def straightened(offsets: np.ndarray, names: list[str]) -> np.ndarray:
    """Return offsets (J, 3) with straight legs and arms of the same lengths, on the figure of the CMU conversion."""
    offsets = offsets.copy()
    for limb in LEGS:
        for joint in limb[1:]:
            k = names.index(joint)
            offsets[k] = [0.0, -np.linalg.norm(offsets[k]), 0.0]
    for limb in ARMS:
        for joint in limb[1:]:
            k = names.index(joint)
            offsets[k] = [np.sign(offsets[k, 0]) * np.linalg.norm(offsets[k]), 0.0, 0.0]
    return offsets


def _raised(captured: Recording, straight: Recording) -> np.ndarray:
    """Return positions (T, J, 3) of the straight-limbed figure, raised, with the feet of the captured one."""
    raises, heights, leg = [], [], 0.0
    for limb in LEGS:
        hip, _, foot = (captured.names.index(joint) for joint in limb)
        way = captured.positions[:, hip] - captured.positions[:, foot]
        reach = np.linalg.norm(straight.positions[:, hip] - straight.positions[:, foot], axis=-1)
        flat = np.linalg.norm(way[:, [0, 2]], axis=-1)
        raises.append(np.sqrt(np.maximum(reach**2 - flat**2, 0.0)) - way[:, 1])
        heights.append(way[:, 1])
        leg += np.linalg.norm(straight.rest[hip] - straight.rest[foot]) / len(LEGS)
    upright = smoothstep((np.max(heights, axis=0) / leg - SEATED) / (UPRIGHT - SEATED))
    raised = straight.positions.copy()
    raised[..., 1] += (np.maximum(np.min(raises, axis=0), 0.0) * upright)[:, None]
    for _, _, joint in LEGS:
        foot = captured.names.index(joint)
        raised[:, foot] = captured.positions[:, foot]
    return raised
