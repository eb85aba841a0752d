"""Place a seated body's hands on a table in front of the seat. Room frame, metres."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ....samp_addon import rotation, skeleton
from ....samp_addon.easing import smoothstep
from ....samp_addon.refine.inverse_kinematics import solve_limb
from ....samp_addon.scene import geometry
from ...fitting.shapes import posing
from ...mocap.events import headings
from ..classes import CLASS
from ..layout.room import Room
from .use import Use

SPACING = 0.02  # metres between samples of table tops
FLAT = 0.95  # least cosine of a top's normal with the vertical
OVER = (0.02, 0.34)  # height (m) of a top over the seated pelvis
EDGE = (0.14, 0.62)  # distance (m) from the pelvis to the near edge
INSIDE = (0.10, 0.04)  # distance (m) from the edge to the wrists, at a near edge and at a distant one
UPRIGHT, LEVER, MOST_LEAN = (
    0.36,
    0.40,
    np.radians(34),
)  # reach (m) without leaning; lever (m) and limit of the lean
ASIDE = (0.12, 0.20)  # lateral distance (m) from the middle to a wrist
WRIST_OVER = 0.035  # metres from the wrist joint to the skin under it
REACHED = 0.02  # largest distance (m) from a wrist to its target
HIT = 0.03  # largest distance (m) from a wrist's target to a sample of the top
TAKING = 14  # frames in which hands are laid down or lifted
LEAST = 45  # frames of the shortest hold in which hands are laid down
INWARDS = np.radians(25)  # angle of the hands from straight ahead


@dataclass(frozen=True)
class Tops:
    """Samples (N, 3) of the tops of tables and desks."""

    points: np.ndarray

    @classmethod
    def of(cls, room: Room) -> Tops:
        """Return the tops in a room."""
        some = room.triangles[room.classes == CLASS["table"]]
        normal = np.cross(some[:, 1] - some[:, 0], some[:, 2] - some[:, 0])
        size = np.linalg.norm(normal, axis=-1)
        flat = some[np.abs(normal[:, 1]) > FLAT * np.maximum(size, 1e-12)]
        if not len(flat):
            return cls(np.zeros((0, 3)))
        area = float(size[np.abs(normal[:, 1]) > FLAT * np.maximum(size, 1e-12)].sum()) / 2
        count = int(min(area / SPACING**2, 60_000)) + 1
        return cls(geometry.sample_surface(flat, count, seed=0)[0])

    def places(self, pelvis: np.ndarray, yaw: float, aside: float) -> np.ndarray | None:
        """Return targets (2, 3) of left and right wrist on a top in front of a seated pelvis (3,); None without one."""
        away = self.points - pelvis
        ahead = away[:, 0] * np.sin(yaw) + away[:, 2] * np.cos(yaw)
        side = away[:, 0] * np.cos(yaw) - away[:, 2] * np.sin(yaw)
        near = (
            (away[:, 1] > OVER[0])
            & (away[:, 1] < OVER[1])
            & (np.abs(side) < 0.3)
            & (ahead > 0)
            & (ahead < 0.9)
        )
        if near.sum() < 40:
            return None
        top = np.percentile(away[near, 1], 95)
        near &= np.abs(away[:, 1] - top) < 0.02
        if not near.any():
            # The percentile is between two tops of different heights.
            return None
        edge = float(np.percentile(ahead[near], 2))
        reach = edge + float(np.interp(edge, [0.3, 0.55], INSIDE))
        if not EDGE[0] < edge < EDGE[1]:
            return None
        found = []
        for out in (1.0, -1.0):
            if np.hypot(ahead[near] - reach, side[near] - out * aside).min() > HIT:
                return None
            found.append([
                pelvis[0] + reach * np.sin(yaw) + out * aside * np.cos(yaw), pelvis[1] + top + WRIST_OVER,
                pelvis[2] + reach * np.cos(yaw) - out * aside * np.sin(yaw),
            ])  # fmt: skip
        return np.array(found)


def with_hands_on(
    use: Use, root: np.ndarray, rotations: np.ndarray, tops: Tops, rng: np.random.Generator
) -> tuple[Use, np.ndarray] | None:
    """Return a sit and its rotations (T, 22, 4) with both hands on the table in front; None where there is none.

    root (T, 3), rotations: of the use in the room.
    """
    hold = slice(use.seated, use.seat_end + 1)
    if use.action != "sit" or use.seat_end - use.seated < LEAST or not len(tops.points):
        return None
    turn = headings(root[hold], rotations[hold])
    yaw = float(np.arctan2(np.sin(turn).mean(), np.cos(turn).mean()))
    places = tops.places(np.median(root[hold], axis=0), yaw, rng.uniform(*ASIDE))
    if places is None:
        return None
    frames = np.arange(len(root))
    weight = smoothstep((frames - use.seated) / TAKING) if use.down >= 0 else np.ones(len(root))
    if use.up_end >= 0:
        weight = np.minimum(weight, smoothstep((use.seat_end - frames) / TAKING))
    hands = use.hands.copy()
    reach = np.linalg.norm((places.mean(0) - np.median(root[hold], axis=0))[[0, 2]])
    lean = float(np.clip((reach - UPRIGHT) / LEVER, 0.0, MOST_LEAN))
    rotations = posing.leant(rotations, 0.0 * weight, lean * weight)
    for column, side, out, target in ((1, "left", 1.0, places[0]), (0, "right", -1.0, places[1])):
        positions, turned = skeleton.forward_kinematics(root, rotations, posing.REST)
        wrist = positions[:, skeleton.INDEX[f"{side}_wrist"]]
        # Keep a small part of the captured hand's motion.
        movement = gaussian_filter1d(wrist - np.median(wrist[hold], axis=0), 8, axis=0, mode="nearest")
        goal = target + np.clip(0.2 * movement, -0.03, 0.03) * [1.0, 0.0, 1.0]
        rotations = solve_limb(
            root, rotations, posing.REST, f"{side}_arm", wrist + weight[:, None] * (goal - wrist)
        )
        flat = np.broadcast_to(
            rotation.about_y(np.array([yaw - out * (np.pi / 2 - INWARDS)])), turned[:, 0].shape
        )
        was = turned[:, skeleton.INDEX[f"{side}_wrist"]]
        rotations = posing.end_turned(root, rotations, f"{side}_wrist", rotation.slerp(was, flat, weight))
        if _off(root, rotations, side, goal, (use.seated + use.seat_end) // 2) > REACHED:
            return None
        hands[:, column] = np.maximum(hands[:, column], weight > 0.9)
    return replace(use, hands=hands), rotation.continuous(rotations)


def _off(root: np.ndarray, rotations: np.ndarray, side: str, goal: np.ndarray, frame: int) -> float:
    """Return the distance, metres, between a wrist and its target (T, 3) in a frame."""
    joints, _ = skeleton.forward_kinematics(root[[frame]], rotations[[frame]], posing.REST)
    return float(np.linalg.norm(joints[0, skeleton.INDEX[f"{side}_wrist"]] - goal[frame]))
