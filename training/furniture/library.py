"""Real furniture: GLB files of the Sweet Home 3D library, and their split into training and held-out pieces."""

from __future__ import annotations

import csv
import hashlib
import json
import struct
from pathlib import Path

import numpy as np

from .piece import Piece

DEFAULT_FOLDER = Path(__file__).resolve().parents[2].parent / "shared" / "data" / "furniture"

SHIPPED_FOLDER = Path(__file__).resolve().parent / "pieces"
"""A few pieces in the public domain, all of them held out; see CREDITS.md there."""

# Misfiled pieces: a car seat and a tablet computer.
NOT_FURNITURE = frozenset({"chair_scopia_seat_leon", "table_scopia_tablet"})

# Variants of one design share a key, so that no held-out piece has a sibling in training.
SIBLINGS = {
    "armchair_blendswapcc0_winchesterArmchair": "winchester",
    "sofa_blendswapcc0_winchesterSofa": "winchester",
    "sofa_scopia_beige_sofa_2seats": "sofa_scopia_beige_sofa",
    "sofa_katorlegaz_mid_century_bench_sofa": "mid_century",
    "sofa_katorlegaz_mid_century_sofa": "mid_century",
    "armchair_katorlegaz_mid_century_chair": "mid_century",
    "table_scopia_wooden_office_alder_table": "wooden_office",
    "table_scopia_wooden_office_pear_table": "wooden_office",
    "table_scopia_wooden_office_pear_table_rect": "wooden_office",
    "table_scopia_wooden_office_teak_table": "wooden_office",
}

_COMPONENTS = {
    5120: np.int8,
    5121: np.uint8,
    5122: np.int16,
    5123: np.uint16,
    5125: np.uint32,
    5126: np.float32,
}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def available(folder: Path = DEFAULT_FOLDER) -> Path:
    """Return the library's folder if it exists, else that of the pieces shipped with the repository."""
    return Path(folder) if (Path(folder) / "manifest.csv").is_file() else SHIPPED_FOLDER


def missing(folder: Path = DEFAULT_FOLDER) -> str:
    """Return one sentence on what cannot be evaluated without the library; empty where the library exists."""
    if available(folder) == Path(folder):
        return ""
    return (
        f"{folder} is missing, so 5 shipped and some procedural pieces are used; with the Sweet Home 3D furniture "
        "there (GLB files and a manifest.csv, see docs/training.md), all held-out pieces are."
    )


def is_held_out(name: str) -> bool:
    """Return whether the piece of a file stem is held out from training: first byte of its SHA-256 modulo 5 is 0."""
    key = SIBLINGS.get(name, name)
    return hashlib.sha256(key.encode()).digest()[0] % 5 == 0


def part_of(name: str) -> str:
    """Return the part of the split to which the piece of a file stem belongs: "training", "tuning" or "final".

    A third of the held-out pieces, by the second byte of their SHA-256 modulo 3, is reserved for final tables; the
    others may be used to choose limits and weights. (Until November 2026 the tables included all held-out pieces; since
    then the final third is not used for any choice.)
    """
    if not is_held_out(name):
        return "training"
    key = SIBLINGS.get(name, name)
    return "final" if hashlib.sha256(key.encode()).digest()[1] % 3 == 0 else "tuning"


def load(folder: Path = DEFAULT_FOLDER, held_out: bool | None = None) -> list[Piece]:
    """Return the pieces in a folder with manifest.csv; ``held_out`` selects one side of the split, None both.

    Raise FileNotFoundError when the folder has no manifest.
    """
    with open(Path(folder) / "manifest.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    pieces = []
    for row in rows:
        name = Path(row["file"]).stem
        if name in NOT_FURNITURE or (held_out is not None and is_held_out(name) != held_out):
            continue
        pieces.append(Piece(row["category"], read_glb(Path(folder) / row["file"]), name))
    return pieces


def read_glb(path: Path) -> np.ndarray:
    """Return triangles (F, 3, 3), metres, of all meshes of a binary glTF 2.0 file, node transforms applied.

    Supports plain triangle lists with float positions; raise ValueError for anything else.
    """
    data = Path(path).read_bytes()
    magic, version, _ = struct.unpack_from("<4sII", data)
    if magic != b"glTF" or version != 2:
        raise ValueError(f"{path} is not a binary glTF 2 file")
    size = struct.unpack_from("<I", data, 12)[0]
    head = json.loads(data[20 : 20 + size])
    body = data[20 + size + 8 :]
    parts: list[np.ndarray] = []

    def visit(index: int, parent: np.ndarray) -> None:
        node = head["nodes"][index]
        world = parent @ _node_matrix(node)
        if "mesh" in node:
            for primitive in head["meshes"][node["mesh"]]["primitives"]:
                corners = _primitive_triangles(head, body, primitive)
                parts.append(corners @ world[:3, :3].T + world[:3, 3])
        for child in node.get("children", []):
            visit(child, world)

    for root in head["scenes"][head.get("scene", 0)]["nodes"]:
        visit(root, np.eye(4))
    if not parts:
        raise ValueError(f"{path} contains no mesh")
    return np.concatenate(parts)


def _node_matrix(node: dict) -> np.ndarray:
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.asarray(node.get("scale", (1.0, 1.0, 1.0)))
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix


def _primitive_triangles(head: dict, body: bytes, primitive: dict) -> np.ndarray:
    if primitive.get("mode", 4) != 4:
        raise ValueError("only plain triangle lists are supported")
    points = _accessor(head, body, primitive["attributes"]["POSITION"]).astype(np.float64)
    if "indices" in primitive:
        points = points[_accessor(head, body, primitive["indices"]).ravel()]
    return points.reshape(-1, 3, 3)


def _accessor(head: dict, body: bytes, index: int) -> np.ndarray:
    accessor = head["accessors"][index]
    if "sparse" in accessor or "bufferView" not in accessor:
        raise ValueError("sparse glTF data is not supported")
    view = head["bufferViews"][accessor["bufferView"]]
    kind, width = np.dtype(_COMPONENTS[accessor["componentType"]]), _WIDTHS[accessor["type"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    stride = view.get("byteStride", kind.itemsize * width)
    return np.ndarray((accessor["count"], width), kind, body, start, (stride, kind.itemsize)).copy()


def write_credits(path: Path, folder: Path = DEFAULT_FOLDER) -> None:
    """Write the creators and licences of the pieces used in training, as CC-BY requires attribution."""
    with open(Path(folder) / "manifest.csv", newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if not is_held_out(Path(row["file"]).stem)]
    with open(path, "w", newline="", encoding="utf-8") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["piece", "creator", "licence"])
        for row in rows:
            stem = Path(row["file"]).stem
            if stem not in NOT_FURNITURE:
                out.writerow([stem, row["creator"], row["licence"]])
