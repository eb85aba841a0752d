"""Furniture for training: procedural pieces, the GLB reader, the held-out split."""

from __future__ import annotations

import csv
import json
import struct
from pathlib import Path

import numpy as np
import pytest
from samp_blender.training import furniture
from samp_blender.training.evaluation import takes
from samp_blender.training.furniture import library
from samp_blender.training.samp.goal_net import dataset

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data" / "furniture"
needs_shared = pytest.mark.skipif(not SHARED.exists(), reason=f"{SHARED.parent.name} data are not here")

# Least and most extent (x, y, z) in metres that people would call normal for the category.
SIZES = {
    "armchair": ((0.55, 0.5, 0.5), (1.5, 1.4, 1.3)),
    "chair": ((0.35, 0.65, 0.35), (0.9, 1.2, 0.9)),
    "stool": ((0.25, 0.35, 0.25), (0.75, 0.56, 0.75)),
    "bar_stool": ((0.25, 0.58, 0.25), (0.75, 1.2, 0.8)),
    "bench": ((0.7, 0.38, 0.28), (2.1, 1.05, 0.9)),
    "sofa": ((1.0, 0.5, 0.6), (3.6, 1.3, 1.3)),
    "l_sofa": ((1.9, 0.6, 1.2), (3.7, 1.1, 2.4)),
    "office_chair": ((0.44, 0.8, 0.44), (1.0, 1.4, 1.0)),
    "pouf": ((0.35, 0.25, 0.26), (0.8, 0.5, 0.8)),
    "bed": ((0.8, 0.14, 1.9), (2.4, 1.4, 2.6)),
    "table": ((0.5, 0.3, 0.4), (2.2, 0.85, 1.3)),
}


@pytest.mark.parametrize("category", furniture.CATEGORIES)
def test_pieces_are_of_normal_size_and_stand_on_the_floor(category):
    rng = np.random.default_rng(4)
    least, most = SIZES[category]
    for _ in range(25):
        piece = furniture.generate(category, rng)
        corners = piece.triangles.reshape(-1, 3)
        size = np.ptp(corners, axis=0)
        assert piece.category == category and piece.triangles.shape[1:] == (3, 3)
        assert np.isfinite(corners).all() and abs(corners[:, 1].min()) < 1e-9
        assert (size >= least).all() and (size <= most).all(), (piece.name, size)


def test_the_same_seed_gives_the_same_piece_and_another_seed_another():
    make = lambda seed: furniture.generate("sofa", np.random.default_rng(seed))
    np.testing.assert_array_equal(make(5).triangles, make(5).triangles)
    assert make(5).name == make(5).name != make(6).name


def test_an_unknown_category_is_refused():
    with pytest.raises(KeyError):
        furniture.generate("throne", np.random.default_rng(0))


def write_glb(path, nodes, points, indices):
    body = points.astype("<f4").tobytes() + indices.astype("<u2").tobytes()
    body += b"\0" * (-len(body) % 4)
    head = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": indices.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": points.size * 4},
            {"buffer": 0, "byteOffset": points.size * 4, "byteLength": indices.size * 2},
        ],
        "buffers": [{"byteLength": len(body)}],
    }
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def test_glb_nodes_are_moved_turned_and_scaled(tmp_path):
    half = np.sqrt(0.5)
    nodes = [
        {"translation": [1, 2, 3], "children": [1]},
        {"mesh": 0, "rotation": [0, half, 0, half], "scale": [2, 1, 1]},
    ]
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1]])
    write_glb(tmp_path / "a.glb", nodes, points, np.array([0, 1, 2]))
    # A quarter turn to the left about Y sends +X to -Z and +Z to +X.
    np.testing.assert_allclose(
        furniture.read_glb(tmp_path / "a.glb"), [[[1, 2, 3], [1, 2, 1], [2, 2, 3]]], atol=1e-6
    )


def test_other_files_are_refused(tmp_path):
    (tmp_path / "a.glb").write_bytes(b"solid nothing of the kind")
    with pytest.raises(ValueError, match="not a binary glTF"):
        furniture.read_glb(tmp_path / "a.glb")


def test_the_split_is_fixed_and_keeps_variants_of_a_design_together():
    assert furniture.is_held_out("chair_blendswapcc0_chair")
    assert not furniture.is_held_out("chair_scopia_chair")
    for name, design in library.SIBLINGS.items():
        twins = [other for other, theirs in library.SIBLINGS.items() if theirs == design]
        assert len({furniture.is_held_out(twin) for twin in [name, *twins]}) == 1


@needs_shared
def test_the_library_is_read_in_metres_and_split_about_four_to_one():
    train, held_out = furniture.load(SHARED, held_out=False), furniture.load(SHARED, held_out=True)
    assert not {p.name for p in train} & {p.name for p in held_out}
    assert 0.15 < len(held_out) / (len(train) + len(held_out)) < 0.3
    assert {p.name for p in [*train, *held_out]} == {p.name for p in furniture.load(SHARED)}
    bed = next(p for p in [*train, *held_out] if p.name == "bed_scopia_bed1")
    np.testing.assert_allclose(np.ptp(bed.triangles.reshape(-1, 3), axis=0), (1.705, 1.108, 2.165), atol=2e-3)


def test_the_shipped_pieces_are_held_out_and_in_the_public_domain(tmp_path):
    folder = furniture.available(tmp_path)
    assert folder == library.SHIPPED_FOLDER and "is missing" in furniture.missing(tmp_path)
    pieces = furniture.load(folder, held_out=True)
    assert len(pieces) == len(furniture.load(folder)) == len(list(folder.glob("*.glb"))) >= 4
    with open(folder / "manifest.csv", newline="", encoding="utf-8") as file:
        assert all(row["licence"].startswith("CC0") for row in csv.DictReader(file))
    credits_text = (folder / "CREDITS.md").read_text("utf-8")
    assert all(piece.name in credits_text for piece in pieces)


def test_evaluation_without_the_library_uses_shipped_and_procedural_pieces(tmp_path, monkeypatch):
    monkeypatch.setattr(furniture, "missing", lambda: "It is missing.")
    monkeypatch.setattr(furniture, "available", lambda: library.SHIPPED_FOLDER)
    names = [piece.name for piece in dataset.real_pieces(held_out=True)]
    assert "chair_blendswapcc0_chair" in names and len(names) > 10
    for action in ("sit", "lie"):
        pieces = takes.held_out_seats(library.SHIPPED_FOLDER, action)
        assert any("blendswap" in piece.name for piece in pieces)
        assert any("blendswap" not in piece.name for piece in pieces)
