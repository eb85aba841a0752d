"""Hair, clothes and shoes for the bare body: the material of each face, and the offset of the cloth from the skin.

The sole stays where the bare foot's is, so that a take's foot heights hold for the shoe.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import linalg as splinalg

from ...samp_addon import skeleton
from ...samp_addon.body.human import MATERIALS

# Heights in metres over a joint (or the floor) at which one garment meets the next.
_HEM = -0.02  # the shirt ends this far above the pelvis joint, over the trousers
_SHOE_TOP = 0.035  # above the ankle
_CUFF = 0.012  # the sleeve ends this far before the wrist
_LEG = 0.058  # radius of a trouser leg
_SOLE = 0.014  # the foot below this height is flattened onto the floor
# The hair begins above this line: metres behind the eye, and above it.
_HAIRLINE = (
    [-0.02, 0.0, 0.03, 0.055, 0.068, 0.08, 0.11, 0.125, 0.16],
    [0.073, 0.068, 0.052, 0.03, 0.008, 0.02, 0.015, -0.035, -0.055],
)
# Offset of each garment from the skin, metres.
_THICKNESS = {"clothes": 0.007, "trousers": 0.006, "shoes": 0.004, "hair": 0.016}


def edge_matrix(faces: np.ndarray, count: int) -> sparse.csr_matrix:
    """Return the symmetric vertex adjacency (V, V) of faces (F, 4)."""
    edges = np.concatenate([faces[:, [k, (k + 1) % 4]] for k in range(4)])
    edges = edges[edges[:, 0] != edges[:, 1]]
    ones = np.ones(len(edges))
    matrix = sparse.coo_matrix((ones, (edges[:, 0], edges[:, 1])), (count, count)).tocsr()
    return ((matrix + matrix.T) > 0).astype(np.float64)


def smoothed(values: np.ndarray, edges: sparse.csr_matrix, mask: np.ndarray, rounds: int) -> np.ndarray:
    """Return values (V, k) smoothed towards their neighbours' mean, weighted by mask (V,) from 0 to 1."""
    mean = sparse.diags(1 / np.asarray(edges.sum(1)).ravel()) @ edges
    values = values.copy()
    for _ in range(rounds):
        values += 0.5 * mask[:, None] * (mean @ values - values)
    return values


def normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the unit vertex normals (V, 3)."""
    corners = vertices[faces]
    face = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    flat = faces[:, 2] == faces[:, 3]
    face[flat] = np.cross(corners[flat, 1] - corners[flat, 0], corners[flat, 2] - corners[flat, 0])
    total = np.zeros_like(vertices)
    for k in range(4):
        np.add.at(total, faces[:, k], face)
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)


def parts_of(vertices: np.ndarray, faces: np.ndarray, joints: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return each face's index into MATERIALS (F,); vertices (V, 3) in the T-pose, metres, weights (V, 55)."""
    return _parts(vertices[faces].mean(axis=1), weights[faces].mean(axis=1), joints)


def dress(
    vertices: np.ndarray, faces: np.ndarray, joints: np.ndarray, parts: np.ndarray, chest: np.ndarray
) -> np.ndarray:
    """Return dressed vertices (V, 3), metres, from bare ones in the T-pose; parts (F,) from parts_of.

    chest: (V,) from 0 to 1, strength with which a loose shirt smooths out the skin below it.
    """
    edges = edge_matrix(faces, len(vertices))
    result = vertices
    for part, rounds in (("clothes", 14), ("trousers", 14), ("shoes", 16)):
        mask = _mask(parts, faces, len(vertices), part)
        result = smoothed(result, edges, mask, rounds)
    result += chest[:, None] * (_stretched(result, edges, chest > 0) - result)
    outward = normals(result, faces)
    for part, thickness in _THICKNESS.items():
        mask = _mask(parts, faces, len(vertices), part)
        if part == "hair":  # thick on the crown, thin towards its border
            mask = (
                np.maximum(smoothed(mask[:, None], edges, np.ones(len(mask)), 12)[:, 0] - 0.5, 0) * 2 * mask
            )
        result = result + outward * (thickness * mask)[:, None]
    result = _straight_legs(result, _mask(parts, faces, len(vertices), "trousers"), joints)
    result = _clean_borders(result, faces, parts, edges)
    return _flat_soles(vertices, result, _mask(parts, faces, len(vertices), "shoes"))


def _stretched(vertices: np.ndarray, edges: sparse.csr_matrix, region: np.ndarray) -> np.ndarray:
    """Return the vertices with those of the region on a membrane stretched across it from its border."""
    mean = sparse.diags(1 / np.asarray(edges.sum(1)).ravel()) @ edges
    pull = (sparse.identity(len(vertices)) - mean).tocsr()
    inside, outside = np.flatnonzero(region), np.flatnonzero(~region)
    result = vertices.copy()
    held = pull[inside][:, outside] @ vertices[outside]
    result[inside] = -splinalg.spsolve(pull[inside][:, inside].tocsc(), held)
    return result


def _straight_legs(vertices: np.ndarray, mask: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Widen trousers below mid-thigh to at least _LEG, so that they do not follow shin and ankle."""
    result = vertices.copy()
    for side, sign in (("left", 1.0), ("right", -1.0)):
        hip, knee, ankle = (joints[skeleton.INDEX[f"{side}_{name}"]] for name in ("hip", "knee", "ankle"))
        own = np.flatnonzero(
            (mask > 0) & (vertices[:, 0] * sign > 0) & (vertices[:, 1] < (hip[1] + knee[1]) / 2)
        )
        height = vertices[own, 1]
        line = [
            np.interp(-height, [-hip[1], -knee[1], -ankle[1]], [hip[k], knee[k], ankle[k]]) for k in (0, 2)
        ]
        off = vertices[own][:, [0, 2]] - np.stack(line, axis=1)
        radius = np.linalg.norm(off, axis=1, keepdims=True)
        wide = np.where(radius < _LEG, _LEG - (_LEG - radius) * 0.15, radius)
        blend = np.clip(((hip[1] + knee[1]) / 2 - height) / 0.12, 0, 1)[:, None]
        result[own[:, None], [0, 2]] += off / radius * (wide - radius) * blend
    return result


def _clean_borders(
    vertices: np.ndarray, faces: np.ndarray, parts: np.ndarray, edges: sparse.csr_matrix
) -> np.ndarray:
    """Smooth the borders between parts, which run in steps along face edges, and then their neighbours."""
    sides = np.concatenate([np.sort(faces[:, [k, (k + 1) % 4]], axis=1) for k in range(4)])
    owner = np.tile(parts, 4)
    sides, owner = sides[sides[:, 0] != sides[:, 1]], owner[sides[:, 0] != sides[:, 1]]
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    sides, owner = sides[order], owner[order]
    twin = (sides[1:] == sides[:-1]).all(axis=1) & (owner[1:] != owner[:-1])
    border = sides[1:][twin]
    count = len(vertices)
    links = sparse.coo_matrix((np.ones(len(border)), (border[:, 0], border[:, 1])), (count, count)).tocsr()
    links = links + links.T
    on_border = np.asarray(links.sum(1)).ravel() > 0
    along = links + sparse.diags((~on_border).astype(float))
    result = smoothed(vertices, along, on_border.astype(float), 12)
    near = ((edges @ on_border.astype(float)) > 0) & ~on_border
    return smoothed(result, edges, near.astype(float), 4)


def _mask(parts: np.ndarray, faces: np.ndarray, count: int, part: str) -> np.ndarray:
    """Return 1 for each vertex (V,) that belongs to a face of the part, else 0."""
    mask = np.zeros(count)
    mask[np.unique(faces[parts == MATERIALS.index(part)])] = 1.0
    return mask


def _flat_soles(bare: np.ndarray, dressed: np.ndarray, shoe: np.ndarray) -> np.ndarray:
    """Flatten the part of the shoe that touches the floor, and keep the shoe above the bare sole."""
    floor = bare[:, 1].min()
    dressed = dressed.copy()
    dressed[(shoe > 0) & (bare[:, 1] < floor + _SOLE), 1] = floor
    dressed[:, 1] = np.maximum(dressed[:, 1], floor)
    return dressed


def _parts(centres: np.ndarray, shares: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Return the material index (F,) of each face from its centre (F, 3) and joint shares (F, 55)."""
    at = lambda name: joints[skeleton.INDEX[name]]
    share = lambda *names: shares[:, [skeleton.INDEX[name] for name in names]].sum(axis=1)
    x, y, z = np.abs(centres[:, 0]), centres[:, 1], centres[:, 2]
    parts = np.full(len(centres), MATERIALS.index("clothes"))
    leg = share("left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle")
    foot = share("left_foot", "right_foot")
    parts[(y < at("pelvis")[1] + _HEM) & (x < 0.4)] = MATERIALS.index("trousers")
    parts[(leg + foot > 0.5) & (y < at("left_ankle")[1] + _SHOE_TOP)] = MATERIALS.index("shoes")
    parts[x > at("left_wrist")[0] - _CUFF] = MATERIALS.index("skin")
    collar = at("neck") + (0, -0.012, 0)
    parts[(y - collar[1] > -0.55 * (z - collar[2]) + 0.9 * np.maximum(x - 0.045, 0)) & (x < 0.12)] = (
        MATERIALS.index("skin")
    )
    parts[_is_hair(x, y, z, share("head"), joints)] = MATERIALS.index("hair")
    return parts


def _is_hair(x: np.ndarray, y: np.ndarray, z: np.ndarray, head: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Flag the scalp: behind a line from the forehead over the temple and behind the ear to the
    nape."""
    eye = joints[skeleton.INDEX["left_eye_smplhf"]]
    back, up = eye[2] - z, y - eye[1]
    line = np.interp(back, *_HAIRLINE)
    ear = (x > 0.066) & (up < 0.018) & (back > 0.06) & (back < 0.13)
    return (head > 0.5) & (up > line) & ~ear


def eyeballs(joints: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return two balls behind the lids, which the source's skin does not include.

    Values: vertices (E, 3), metres, faces (G, 4) numbered from ``first``, materials (G,) and each vertex's
    joint (E,).
    """
    rings, sectors, radius = 10, 16, 0.0123
    vertices, faces, materials, owners = [], [], [], []
    for side in ("left", "right"):
        joint = skeleton.INDEX[f"{side}_eye_smplhf"]
        start = first + len(vertices)
        for ring in range(rings + 1):
            polar = np.pi * ring / rings
            for sector in range(sectors):
                around = 2 * np.pi * sector / sectors
                way = (np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar))
                vertices.append(joints[joint] + radius * np.array(way))
                owners.append(joint)
        for ring in range(rings):
            for sector in range(sectors):
                a, b = start + ring * sectors + sector, start + ring * sectors + (sector + 1) % sectors
                faces.append((a, a + sectors, b + sectors, b))
                materials.append(MATERIALS.index("pupils" if ring < 2 else "eyes"))
    return np.array(vertices), np.array(faces), np.array(materials), np.array(owners)
