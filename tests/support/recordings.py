"""A known walk, and small writers of the files that motion capture comes in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.easing import smoothstep
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.refine.feet.foot import BALL_HEIGHT
from samp_blender.samp_addon.refine.inverse_kinematics import solve_limb
from scipy.spatial.transform import Rotation

REST = skeleton.default_rest_joints()[:22]
OFFSETS = REST - REST[np.maximum(skeleton.PARENTS[:22], 0)]
MIXAMO = dict(
    pelvis="Hips", spine1="Spine", spine2="Spine1", spine3="Spine2", neck="Neck", head="Head",
    **{f"{s}_{part}": f"{s.capitalize()}{bone}" for s in ("left", "right") for part, bone in (
        ("hip", "UpLeg"), ("knee", "Leg"), ("ankle", "Foot"), ("foot", "ToeBase"), ("collar", "Shoulder"),
        ("shoulder", "Arm"), ("elbow", "ForeArm"), ("wrist", "Hand"))},
)  # fmt: skip


def walk(count: int = 90, speed: float = 1.1, fps: float = 30.0, turn: float = 0.0) -> Motion:
    """Somebody who walks towards +Z, turned by ``turn`` radians: feet that stand flat and still for 60 % of a step of
    0.8 s, and go on level soles. With speed 0 they step on the spot."""
    t = np.arange(count) / fps
    vectors = np.zeros((count, 22, 3))
    at = skeleton.INDEX
    phase = t / 0.8
    for side, sign in (("left", 1.0), ("right", -1.0)):
        vectors[:, at[f"{side}_shoulder"], 2] = -1.2 * sign
        vectors[:, at[f"{side}_shoulder"], 1] = 0.3 * np.sin(2 * np.pi * phase) * sign
        vectors[:, at[f"{side}_elbow"], 1] = -0.35 * sign
        vectors[:, at[f"{side}_knee"], 0] = 0.2
    vectors[:, at["spine2"], 1] = 0.08 * np.sin(2 * np.pi * phase)
    vectors[:, at["head"], 0] = 0.1
    rotations = rotation.from_axis_angle(vectors)
    ankle = REST[at["left_ankle"], 1] - REST[at["left_foot"], 1] + BALL_HEIGHT  # over the floor
    root = np.stack([0.015 * np.sin(2 * np.pi * phase), np.full(count, ankle - REST[at["left_ankle"], 1] - 0.06),
                     speed * t], -1)  # fmt: skip
    for side, shift in (("left", 0.0), ("right", 0.5)):
        step, share = np.divmod(phase + shift, 1.0)
        swing = np.clip((share - 0.6) / 0.4, 0.0, 1.0)
        ahead = (step - shift + 0.3 + smoothstep(swing)) * 0.8 * speed
        target = np.stack([np.full(count, REST[at[f"{side}_ankle"], 0]),
                           ankle + 0.08 * np.sin(np.pi * swing) ** 2, ahead], -1)  # fmt: skip
        rotations = solve_limb(root, rotations, REST, f"{side}_leg", target)
        _, globals_ = skeleton.forward_kinematics(root, rotations, REST)
        rotations[:, at[f"{side}_ankle"]] = rotation.conjugate(globals_[:, at[f"{side}_knee"]])
    return Motion(*turned(root, rotations, turn), fps)


def turned(root: np.ndarray, rotations: np.ndarray, yaw: float) -> tuple[np.ndarray, np.ndarray]:
    """The motion turned about the vertical."""
    turn = rotation.about_y(yaw)
    rotations = rotations.copy()
    rotations[:, 0] = rotation.multiply(np.broadcast_to(turn, rotations[:, 0].shape), rotations[:, 0])
    return rotation.rotate(np.broadcast_to(turn, (len(root), 4)), root), rotations


def scipy_rotation(quaternions: np.ndarray) -> Rotation:
    """The same rotations for scipy, which has the real part last."""
    return Rotation.from_quat(np.reshape(quaternions, (-1, 4))[:, [1, 2, 3, 0]])


def write_bvh(
    path: Path, motion: Motion, order: str = "ZXY", unit: float = 100.0, up: str = "Y", names: dict | None = None,
    rest: np.ndarray | None = None,
) -> Path:  # fmt: skip
    """A .bvh of a motion. order: of the Euler channels. up: "Y", or "Z" with +Y behind. rest: quaternions (22, 4),
    global, of another rest pose than the T-pose."""
    names = MIXAMO if names is None else names
    axes = np.eye(3) if up == "Y" else np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    parents = skeleton.PARENTS[:22]
    _, globals_ = skeleton.forward_kinematics(motion.root, motion.rotations, REST)
    offsets = OFFSETS
    if rest is not None:
        offsets = np.array([rotation.rotate(rest[max(p, 0)], OFFSETS[j]) for j, p in enumerate(parents)])
        globals_ = rotation.multiply(globals_, rotation.conjugate(rest))
    local = rotation.change_basis(skeleton.local_rotations(globals_), axes)
    angles = scipy_rotation(local).as_euler(order, degrees=True).reshape(len(motion), 22, 3)
    lines = ["HIERARCHY"]

    def joint(j: int, depth: int) -> None:
        tab = "\t" * depth
        lines.append(f"{tab}{'JOINT' if j else 'ROOT'} {names[skeleton.JOINTS[j]]}")
        lines.append(tab + "{")
        offset = axes @ offsets[j] * unit if j else np.zeros(3)
        lines.append(f"{tab}\tOFFSET " + " ".join(f"{v:.6f}" for v in offset))
        channels = [f"{letter}rotation" for letter in order]
        if not j:
            channels = ["Xposition", "Yposition", "Zposition", *channels]
        lines.append(f"{tab}\tCHANNELS {len(channels)} " + " ".join(channels))
        below = np.flatnonzero(parents == j)
        for child in below:
            joint(int(child), depth + 1)
        if not len(below):
            lines.extend([f"{tab}\tEnd Site", tab + "\t{", f"{tab}\t\tOFFSET 0 0 0", tab + "\t}"])
        lines.append(tab + "}")

    joint(0, 0)
    lines += ["MOTION", f"Frames: {len(motion)}", f"Frame Time: {1 / motion.fps:.8f}"]
    written: list[int] = []

    def listed(j: int) -> None:
        written.append(j)
        for child in np.flatnonzero(parents == j):
            listed(int(child))

    listed(0)
    for t in range(len(motion)):
        values = [*(axes @ motion.root[t] * unit), *(v for j in written for v in angles[t, j])]
        lines.append(" ".join(f"{v:.6f}" for v in values))
    path.write_text("\n".join(lines) + "\n")
    return path


ACCLAIM = dict(
    pelvis="root", spine1="lowerback", spine2="upperback", spine3="thorax", neck="lowerneck", head="head",
    **{f"{s}_{part}": f"{s[0]}{bone}" for s in ("left", "right") for part, bone in (
        ("hip", "femur"), ("knee", "tibia"), ("ankle", "foot"), ("foot", "toes"), ("collar", "clavicle"),
        ("shoulder", "humerus"), ("elbow", "radius"), ("wrist", "hand"))},
)  # fmt: skip


def write_acclaim(folder: Path, motion: Motion, name: str = "07_01", tilt: float = 20.0) -> Path:
    """07.asf and 07_01.amc of a motion; bones have their own axes, tilted by some degrees about Z.

    An Acclaim joint begins where one bone ends, so each joint with several children gets a bone without motion to
    each of them (as "lhipjoint" is).
    """
    unit = 0.45 / 0.0254
    parents = skeleton.PARENTS[:22]
    bones, hierarchy = [], []
    axes = [f"0 0 {tilt if j % 2 else -tilt}" for j in range(22)]

    def bone(name: str, vector: np.ndarray, axis: str, moves: bool) -> None:
        length = max(np.linalg.norm(vector), 1e-6)
        way = vector / length
        bones.append(
            f"  begin\n    name {name}\n    direction {way[0]:.9f} {way[1]:.9f} {way[2]:.9f}\n"
            f"    length {length * unit:.9f}\n    axis {axis} XYZ\n"
            + ("    dof rx ry rz\n" if moves else "")
            + "  end"
        )

    for j in range(22):
        below = np.flatnonzero(parents == j)
        own = ACCLAIM[skeleton.JOINTS[j]]
        direct = len(below) == 1 and j > 0
        if j:
            bone(own, OFFSETS[below[0]] if direct else np.array([0.0, 1e-5, 0.0]), axes[j], True)
        for child in below:
            if direct:
                hierarchy.append(f"    {own} {ACCLAIM[skeleton.JOINTS[child]]}")
            else:
                link = f"to_{ACCLAIM[skeleton.JOINTS[child]]}"
                bone(link, OFFSETS[child], "0 0 0", False)
                hierarchy += [f"    {own} {link}", f"    {link} {ACCLAIM[skeleton.JOINTS[child]]}"]
    (folder / f"{name.split('_')[0]}.asf").write_text(
        ":version 1.10\n:name test\n:units\n  mass 1.0\n  length 0.45\n  angle deg\n:root\n"
        "  order TX TY TZ RX RY RZ\n  axis XYZ\n  position 0 0 0\n  orientation 0 0 0\n:bonedata\n"
        + "\n".join(bones) + "\n:hierarchy\n  begin\n" + "\n".join(hierarchy) + "\n  end\n"
    )  # fmt: skip
    lines = [":FULLY-SPECIFIED", ":DEGREES"]
    for t in range(len(motion)):
        lines.append(str(t + 1))
        for j in range(22):
            own = scipy_rotation(motion.rotations[t, j])
            if j:
                frame = Rotation.from_euler("xyz", np.fromstring(axes[j], sep=" "), degrees=True)
                own = frame.inv() * own * frame
            angles = own.as_euler("xyz", degrees=True)[0]
            values = [*(motion.root[t] * unit), *angles] if not j else angles
            lines.append(f"{ACCLAIM[skeleton.JOINTS[j]]} " + " ".join(f"{v:.8f}" for v in values))
    path = folder / f"{name}.amc"
    path.write_text("\n".join(lines) + "\n")
    return path


def write_source(path: Path, motion: Motion, label: str = "walk") -> Path:
    """The .npz form of public conversions."""
    moved = motion.rotations[..., [1, 2, 3, 0]]
    np.savez(
        path, root_pos=motion.root, local_quat_xyzw=moved, offsets=OFFSETS, parents=skeleton.PARENTS[:22],
        names=[MIXAMO[name] for name in skeleton.BODY_JOINTS], fps=motion.fps,
        label=np.zeros(len(motion), np.uint8), label_names=np.array([label]),
    )  # fmt: skip
    return path
