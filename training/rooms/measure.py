"""Measure a corpus: walking, standing and sitting, compared with captured people.

python -m samp_blender.training.rooms.measure --output cache/rooms --mocap FOLDER --episodes 60
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy.linalg import sqrtm

from ...samp_addon import rotation, skeleton
from ...samp_addon.evaluation import feet, rest_posture
from ...samp_addon.evaluation.obstacles import Obstacles
from ...samp_addon.motion import Motion
from ...samp_addon.scene import geometry
from ..mocap import clip_files
from ..mocap.posture import neutralised
from .classes import CLASS
from .corpus import store
from .episodes import depth
from .episodes.bank import LABELS, SETS
from .make import DEFAULT_MOCAP

DEEP = 0.02  # penetration (m) from which an episode counts as deep
STRIDE = 10  # stride of the frames in which penetration is measured
COMPONENTS = 24  # principal components of a pose, for Fréchet distances
KNEES = (("left_hip", "left_knee", "left_ankle"), ("right_hip", "right_knee", "right_ankle"))


def knee_flexion(motion: Motion) -> np.ndarray:
    """Return the flexion (T, 2) of both knees, degrees."""
    joints, _ = motion.forward_kinematics()
    out = []
    for names in KNEES:
        hip, knee, ankle = (joints[:, skeleton.INDEX[name]] for name in names)
        a, b = knee - hip, ankle - knee
        cosine = (a * b).sum(-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
        out.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return np.stack(out, -1)


def jerk(motion: Motion) -> float:
    """Return the 99th percentile of the joints' jerk, m/s^3."""
    joints, _ = motion.forward_kinematics()
    return float(np.percentile(np.linalg.norm(np.diff(joints, 3, axis=0), axis=-1) * motion.fps**3, 99))


def hard_obstacles(data: store.RoomData) -> Obstacles:
    """Return the hard objects of a room, walls included."""
    room = data.room
    soft = [k for k, c in enumerate(room.categories) if c in depth.SOFT]
    shell = np.isin(room.classes, [CLASS["floor"], CLASS["ceiling"]])
    return Obstacles(room.triangles[~np.isin(room.objects, soft) & ~shell])


def leaning(data: store.RoomData, episode: int) -> list[float]:
    """Return the gap, metres, between upper back and piece in the middle of each sit on a piece with a back."""
    first, last = (int(v) for v in data.bounds[episode : episode + 2])
    labels, objects = data.array("motion", "labels")[first:last], data.array("motion", "objects")[first:last]
    sits = np.flatnonzero(labels == LABELS.index("sit"))
    out = []
    for run in np.split(sits, np.flatnonzero(np.diff(sits) > 1) + 1):
        if len(run) < 30:
            continue
        frame = int(run[len(run) // 2])
        motion = data.motion(episode, frame, 1)
        piece = data.room.triangles[data.room.objects == objects[frame]]
        if not len(piece):
            continue
        points, _ = geometry.sample_surface(piece, 8000, seed=0)
        found = rest_posture.back_gap(motion, 0, points, data.body(episode))
        if found is not None:
            out.append(found)
    return out


def pose_vectors(rotations: np.ndarray) -> np.ndarray:
    """Return rotations (T, 22, 4) without the pelvis as vectors (T, 126): two columns of each matrix."""
    return rotation.quaternion_to_matrix(rotations[:, 1:22])[..., :2].reshape(len(rotations), 126)


def frechet(a: np.ndarray, b: np.ndarray, axes: np.ndarray, middle: np.ndarray) -> float:
    """Return the Fréchet distance of poses (N, 126) and (M, 126) in the subspace of axes (126, C)."""
    a, b = (a - middle) @ axes, (b - middle) @ axes
    cov_a, cov_b = np.cov(a.T), np.cov(b.T)
    mixed = sqrtm(cov_a @ cov_b).real
    return float(((a.mean(0) - b.mean(0)) ** 2).sum() + np.trace(cov_a + cov_b - 2 * mixed))


def captured_reference(folder: Path, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return knees, stance slides and jerks of captured clips, and seated poses of training and held-out clips."""
    clips = [c for name in SETS for c in neutralised(clip_files.load_clips(folder / name))]
    chosen = [clips[k] for k in rng.permutation(len(clips))[:120]]
    motions = [
        (c, Motion(c.root, c.rotations))
        for c in chosen
        if len(c) > 60 and not set(c.labels) & {"run", "other"}
    ]
    pick = lambda label: np.concatenate([knee_flexion(m)[c.labels == label].ravel() for c, m in motions])
    slides = [feet.measures(m)["stance_slide_cm_s"] for _, m in motions]
    held = [
        c
        for c in clip_files.load_clips(folder / "test")
        if c.name.startswith("rb_") and (c.labels == "sit").mean() > 0.9
    ]
    seated = [c for c in clips if c.name.startswith("rb_") and (c.labels == "sit").mean() > 0.95]
    return {
        "idle": pick("idle"), "walk": pick("walk"), "slide": np.array([s for s in slides if s is not None]),
        "jerk": np.array([jerk(m) for _, m in motions]),
        "held": np.concatenate([pose_vectors(c.rotations) for c in held]) if held else np.zeros((0, 126)),
        "seated": np.concatenate([pose_vectors(c.rotations) for c in seated]),
        "halves": np.repeat(np.arange(len(seated)) % 2, [len(c) for c in seated]),
    }  # fmt: skip


def measure(corpus: store.Corpus, folder: Path, count: int, seed: int) -> dict[str, object]:
    """Return the measures of ``count`` random episodes and of captured clips."""
    rng = np.random.default_rng(seed)
    every = [(r["number"], e) for r in corpus.manifest["rooms"] for e in range(r["episodes"])]
    chosen = sorted(every[k] for k in rng.permutation(len(every))[:count])
    deep, knees, slides, jerks, leans, poses = [], {"idle": [], "walk": []}, [], [], [], []
    hard: tuple[int, Obstacles | None] = (-1, None)
    for number, episode in chosen:
        data = corpus.room(number)
        if hard[0] != number:
            hard = number, hard_obstacles(data)
        motion, body = data.motion(episode), data.body(episode)
        few = motion.pose_slice(slice(None, None, STRIDE))
        both = (depth.skin_depth(hard[1], few, body), depth.surface_depth(hard[1], few, body))
        deep.append(float(np.maximum(*both).max()))
        first, last = (int(v) for v in data.bounds[episode : episode + 2])
        labels = data.array("motion", "labels")[first:last]
        flexion = knee_flexion(motion)
        for name, values in knees.items():
            values.append(flexion[labels == LABELS.index(name)].ravel())
        slide = feet.measures(motion, body=body)["stance_slide_cm_s"]
        slides += [slide] if slide is not None else []
        jerks.append(jerk(motion))
        leans += leaning(data, episode)
        poses.append(pose_vectors(motion.rotations[labels == LABELS.index("sit")][::10]))
    real = captured_reference(folder, rng)
    idle, walk = (np.concatenate(knees[name]) for name in ("idle", "walk"))
    middle = real["seated"].mean(0)
    axes = np.linalg.svd(real["seated"][::5] - middle, full_matrices=False)[2][:COMPONENTS].T
    mine = np.concatenate(poses)
    rooms, deep, leans = corpus.manifest["rooms"], np.array(deep), np.array(leans)
    touching = leans <= rest_posture.TOUCHING_BACK
    frames = np.array([r["frames"] for r in rooms])
    return {
        "rooms, episodes, hours": (len(rooms), sum(r["episodes"] for r in rooms), round(corpus.manifest["hours"], 2)),
        "frames as captured, degrees before (joined) and after IK": {
            name: round(float(np.average([r["captured"][name] for r in rooms], weights=frames)), 3)
            for name in rooms[0]["captured"]
        },
        "episodes deeper than 2 cm": (round(float((deep > DEEP).mean()), 3), len(deep)),
        "depth, 50 and 90 %": np.percentile(deep, [50, 90]).round(3).tolist(),
        "knees idle, walk, straightest 20th": _knees(idle, walk),
        "captured": _knees(real["idle"], real["walk"]),
        "stance slide cm/s, captured": (round(float(np.mean(slides)), 2), round(float(real["slide"].mean()), 2)),
        "jerk m/s3, captured": (round(float(np.median(jerks))), round(float(np.median(real["jerk"])))),
        "back to rest <= 3 cm, sits": (round(float(touching.mean()), 2) if len(leans) else None, len(leans)),
        "back to rest, median m": round(float(np.median(leans)), 3) if len(leans) else None,
        "seated FD to held-out": round(frechet(mine, real["held"], axes, middle), 2) if len(real["held"]) else None,
        "seated FD captured to held-out": round(frechet(real["seated"], real["held"], axes, middle), 2)
        if len(real["held"]) else None,
        "seated FD of two halves": round(
            frechet(real["seated"][real["halves"] == 0], real["seated"][real["halves"] == 1], axes, middle), 2),
    }  # fmt: skip


def _knees(idle: np.ndarray, walk: np.ndarray) -> list[float]:
    both = np.concatenate([idle, walk])
    return [round(float(v), 1) for v in (np.median(idle), np.median(walk), np.percentile(both, 5))]


def main(arguments: list[str] | None = None) -> int:
    """Run the command; return its exit status."""
    parser = argparse.ArgumentParser(prog="measure", description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path("cache/rooms"), help="folder of the corpus")
    parser.add_argument("--mocap", type=Path, default=DEFAULT_MOCAP)
    parser.add_argument("--episodes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    for name, value in measure(
        store.Corpus(options.output), options.mocap, options.episodes, options.seed
    ).items():
        print(f"{name}: {value}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
