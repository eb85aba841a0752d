"""Read and write takes as AMASS SMPL-X .npz files, the exchange format of SMPL-X tools.

AMASS is Z-up. Its ``trans`` is not the pelvis: SMPL-X turns the body about the rest pelvis J0 and then adds
``trans``, so pelvis = J0 + trans. J0 is that of SMPL-X's mean body, since exported files carry betas of
zero.
"""

from __future__ import annotations

import os
import zipfile
import zlib
from pathlib import Path

import numpy as np

from .. import frames, rotation
from ..errors import SampError
from ..motion import Motion
from .hands import complete

# Rest pelvis of SMPL-X's mean body, metres, Y up.
REST_PELVIS = np.array([0.0031, -0.3514, 0.0120])
_PARTS = {
    "root_orient": (0, 1),
    "pose_body": (1, 22),
    "pose_jaw": (22, 23),
    "pose_eye": (23, 25),
    "pose_hand": (25, 55),
}
# Additional keys, so that reading restores all that was written.
_EXTRA = {"contacts": "samp_contacts", "actions": "samp_actions"}
_START = "samp_interaction_start"
_READ = {"poses", "trans", "mocap_frame_rate", "mocap_framerate", *_PARTS, *_EXTRA.values(), _START}
"""The keys that are read."""
MIN_FPS, MAX_FPS = 1, 1000
"""Frames per second of a valid file."""
_UNREADABLE = (OSError, EOFError, ValueError, zipfile.BadZipFile, AttributeError)


def write_amass(motion: Motion, path: str | Path, gender: str = "neutral") -> Path:
    """Write a take at its own frame rate; missing fingers are relaxed. Return the path, which ends in .npz.

    Raises SampError for a take with values that are not finite, and where the file cannot be written.
    """
    if len(motion) == 0 or not (np.isfinite(motion.root).all() and np.isfinite(motion.rotations).all()):
        raise SampError("The take is empty or holds values that are not numbers; generate it again.")
    turn = rotation.matrix_to_quaternion(frames.BLENDER_FROM_NETWORK)
    quaternions = complete(motion.rotations)
    quaternions[:, 0] = rotation.multiply(turn, quaternions[:, 0])
    vectors = rotation.to_axis_angle(quaternions).astype(np.float32)
    content = {
        "gender": np.array(gender),
        "surface_model_type": np.array("smplx"),
        "mocap_frame_rate": np.array(float(motion.fps)),
        "mocap_time_length": np.array(len(motion) / motion.fps),
        "num_betas": np.array(16),
        "betas": np.zeros(16, dtype=np.float32),
        "trans": (frames.to_blender(motion.root) - REST_PELVIS).astype(np.float32),
        "poses": vectors.reshape(len(motion), -1),
    }
    for key, (first, last) in _PARTS.items():
        content[key] = vectors[:, first:last].reshape(len(motion), -1)
    for name, key in _EXTRA.items():
        if getattr(motion, name) is not None:
            content[key] = getattr(motion, name).astype(np.float32)
    if motion.interaction_start is not None:
        content[_START] = np.array(motion.interaction_start)
    path = Path(path).with_suffix(".npz")
    _write_atomically(path, content)
    return path


def _write_atomically(path: Path, content: dict[str, np.ndarray]) -> None:
    """Write a temporary file in the same folder and move it into place, so that no partial file remains.

    Raises SampError.
    """
    part = path.with_name(
        f".{os.getpid()}.part"
    )  # short: the file's own name may already be as long as allowed
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with part.open("wb") as file:
                np.savez_compressed(file, **content)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise SampError(f"'{path}' cannot be written ({error.strerror}); choose another folder.") from error


def read_amass(path: str | Path) -> Motion:
    """Read an AMASS file of an SMPL, SMPL-H or SMPL-X body: 22 joints, or 55 for SMPL-X.

    The body's shape (betas) needs SMPL-X's model files and is not read. The rest pelvis of the mean body is used
    instead, so that the root is off by their difference, a few centimetres. Raises SampError for a file that is
    missing, unreadable or no AMASS motion.
    """
    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as data:
            # Published files also hold dictionaries and names, which only pickle would read.
            content = {key: data[key] for key in data.files if key in _READ}
            content = {key: value for key, value in content.items() if value.dtype.kind in "fiu"}
    except FileNotFoundError as error:
        raise SampError(f"There is no file '{path}'; choose an AMASS .npz file.") from error
    # zlib.error and NotImplementedError: corrupt content.
    except (*_UNREADABLE, zlib.error, NotImplementedError) as error:
        raise SampError(
            f"'{path}' is not an .npz file that can be read; choose an AMASS .npz file."
        ) from error
    poses, rate = _poses(content), _rate(content)
    if poses is None or rate is None or content.get("trans", np.empty(0)).shape != (len(poses), 3):
        raise SampError(
            f"'{path.name}' is not an AMASS motion: it needs poses, trans and mocap_frame_rate; "
            "choose another file."
        )
    if not (np.isfinite(poses).all() and np.isfinite(content["trans"]).all()):
        raise SampError(f"'{path.name}' holds values that are not numbers; choose another file.")
    if not MIN_FPS <= rate <= MAX_FPS:
        raise SampError(
            f"'{path.name}' has {rate:g} frames per second; choose a file with {MIN_FPS} to {MAX_FPS}."
        )
    vectors = poses[:, : 165 if poses.shape[1] >= 165 else 66].reshape(len(poses), -1, 3)
    quaternions = rotation.continuous(rotation.from_axis_angle(vectors))
    turn = rotation.matrix_to_quaternion(frames.NETWORK_FROM_BLENDER)
    quaternions[:, 0] = rotation.multiply(turn, quaternions[:, 0])
    extra = {
        name: content[key].astype(np.float64)
        for name, key in _EXTRA.items()
        if content.get(key, np.empty(0)).shape == (len(poses), 5)
    }
    if _START in content:
        extra["interaction_start"] = int(content[_START])
    root = frames.to_network(content["trans"] + REST_PELVIS)
    return Motion(root=root, rotations=quaternions, fps=rate, **extra)


def _rate(content: dict[str, np.ndarray]) -> float | None:
    """Return the frames per second, or None where the file does not hold one number."""
    rate = content.get("mocap_frame_rate", content.get("mocap_framerate"))
    value = float(rate.reshape(())) if rate is not None and rate.size == 1 else np.nan
    return value if np.isfinite(value) else None


def _poses(content: dict[str, np.ndarray]) -> np.ndarray | None:
    """Return rotation vectors (T, 66 or more) from ``poses`` or its parts, or None without either."""
    if "poses" in content:
        poses = content["poses"]
    elif all(key in content for key in _PARTS):
        poses = np.concatenate([content[key] for key in _PARTS], axis=1)
    elif "root_orient" in content and "pose_body" in content:
        poses = np.concatenate([content["root_orient"], content["pose_body"]], axis=1)
    else:
        return None
    return poses if poses.ndim == 2 and len(poses) and poses.shape[1] >= 66 else None
