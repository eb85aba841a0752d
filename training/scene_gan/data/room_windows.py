"""Windows of motion in a room, and which of them begin in view of a picture's camera."""

from __future__ import annotations

import numpy as np

from ....samp_addon import skeleton
from ...rooms.corpus.store import RoomData
from ...rooms.pictures.camera import Camera

WINDOW = 65  # frames: the given one and the 64 that follow
BEFORE = 1  # frames before it, for its velocities
EVERY = 15  # frames between the beginnings of two windows
MARGIN = 0.04  # widths of the picture; joints nearer to its edge do not count as seen
HIDDEN = 0.3  # metres behind the visible surface from which a joint is hidden
SEEN = 0.6  # share of the joints that are seen at the beginning
NEAREST, FARTHEST = 1.2, 8.0  # metres between camera and pelvis


def of_room(data: RoomData, most: int, rng: np.random.Generator, wanted: np.ndarray) -> dict[str, np.ndarray]:
    """Return windows of a room's episodes: at most ``most`` at random, and the wanted ones.

    wanted: (P, 2) episode and frame at which the pictures were made; their windows come first. Arrays: episode, frame
    (W,) of the given frame. Windows at the very beginning of an episode repeat its first frame.
    """
    bounds = np.array(data.bounds)
    rows = [
        (episode, frame)
        for episode, length in enumerate(np.diff(bounds))
        for frame in range(0, int(length) - WINDOW + 1, EVERY)
    ]
    chosen = [rows[k] for k in np.sort(rng.permutation(len(rows))[:most])]
    lengths = np.diff(bounds)
    first = [(int(e), int(f)) for e, f in wanted if f + WINDOW <= lengths[e]]
    every = np.array([*first, *chosen], np.int32).reshape(-1, 2)
    return {"episode": every[:, 0], "frame": every[:, 1]}


def motion(data: RoomData, windows: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return root (W, 66, 3) float32, rotations (W, 66, 22, 4) int16, labels (W, 66) uint8, and rest joints (E, 22, 3)
    of the episodes' bodies."""
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
    """Return which bodies (W,) with joints (W, 22, 3) are seen. depth: (H, W) millimetres, of the empty room."""
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
