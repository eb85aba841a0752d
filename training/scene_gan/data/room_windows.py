"""Windows of motion in a room, and the selection of those that begin in view of a camera."""

from __future__ import annotations

import numpy as np

from ....samp_addon import skeleton
from ...rooms.corpus.store import RoomData
from ...rooms.pictures.camera import Camera

WINDOW = 65  # frames: the given one and the 64 that follow
BEFORE = 1  # frames before the given one, for velocities
EVERY = 15  # frames between the starts of two windows
MARGIN = 0.04  # margin, in picture widths, within which joints do not count as visible
HIDDEN = 0.3  # distance (m) behind the visible surface from which a joint is hidden
SEEN = 0.6  # least share of visible joints at the start
NEAREST, FARTHEST = 1.2, 8.0  # distances (m) between camera and pelvis


def of_room(data: RoomData, most: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return at most ``most`` random windows of a room's episodes: episode and given frame (W,).

    Windows at the start of an episode repeat its first frame.
    """
    rows = [
        (episode, frame)
        for episode, length in enumerate(np.diff(np.array(data.bounds)))
        for frame in range(0, int(length) - WINDOW + 1, EVERY)
    ]
    every = np.array([rows[k] for k in np.sort(rng.permutation(len(rows))[:most])], np.int32).reshape(-1, 2)
    return {"episode": every[:, 0], "frame": every[:, 1]}


def motion(data: RoomData, windows: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return root (W, 66, 3) float32, rotations (W, 66, 22, 4) int16, labels (W, 66) uint8, and rest (E, 22, 3).

    rest: rest joints of the bodies of E episodes, metres.
    """
    bounds = np.array(data.bounds)
    offsets = np.maximum(windows["frame"][:, None] + np.arange(-BEFORE, WINDOW), 0)
    rows = bounds[windows["episode"]][:, None] + offsets
    rest = np.stack([data.build(e).body.joints[: skeleton.BODY_COUNT] for e in range(len(bounds) - 1)])
    return {
        "root": np.array(data.array("motion", "root"))[rows],
        "rotations": np.array(data.array("motion", "rotations"))[rows],
        "labels": np.array(data.array("motion", "labels"))[rows],
        "rest": rest.astype(np.float32),
    }


def first_joints(made: dict[str, np.ndarray], body: np.ndarray) -> np.ndarray:
    """Return the joints (W, 22, 3) of the given frames in the room. body: (W,) index into rest."""
    quats = made["rotations"][:, BEFORE].astype(np.float64)
    quats /= np.linalg.norm(quats, axis=-1, keepdims=True)
    out = np.empty((len(body), skeleton.BODY_COUNT, 3))
    for number in np.unique(body):
        mine = body == number
        out[mine] = skeleton.forward_kinematics(
            made["root"][mine, BEFORE].astype(np.float64),
            quats[mine],
            made["rest"][number].astype(np.float64),
        )[0]
    return out


def in_view(joints: np.ndarray, camera: Camera, depth: np.ndarray) -> np.ndarray:
    """Flag the bodies (W,) in view, from joints (W, 22, 3). depth: (H, W) millimetres, of the empty room."""
    height, width = depth.shape
    pixels, ahead = camera.project(joints, (width, height))
    edge = MARGIN * width
    inside = (pixels > edge).all(-1) & (pixels < np.array([width, height]) - edge).all(-1)
    at = np.clip(pixels.astype(int), 0, np.array([width, height]) - 1)
    surface = depth[at[..., 1], at[..., 0]] / 1000.0
    free = (surface == 0) | (ahead < surface + HIDDEN)
    pelvis = ahead[:, 0]
    share = (inside & free & (ahead > 0.3)).mean(-1)
    return (share >= SEEN) & inside[:, 0] & (pelvis > NEAREST) & (pelvis < FARTHEST)
