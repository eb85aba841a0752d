"""Pieces of furniture: what belongs to a target, pieces of a joined room, scattered blades, heights over the floor."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.errors import PathError, SampError
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.scene import geometry
from samp_blender.samp_addon.scene.distance import signed_distance
from samp_blender.samp_addon.scene.furniture import parts, room, scatter
from samp_blender.samp_addon.scene.furniture.belongings import belongings
from samp_blender.samp_addon.scene.furniture.floor import floor_beside
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from samp_blender.samp_addon.scene.navmesh import navmesh, path
from samp_blender.samp_addon.scene.seats import seats

CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
FACES = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
        *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ]
)


def boxes(*corners):
    """Return triangles (F, 3, 3) of boxes ((x, y, z), (x, y, z)), metres, Y up."""
    return np.concatenate(
        [(np.array(low) + CORNERS * (np.array(high) - np.array(low)))[FACES] for low, high in corners]
    )


FLOOR = boxes(((-4, -0.1, -4), (4, 0, 4)))
SOFA = [
    ((-0.9, 0.06, -0.42), (0.9, 0.43, 0.42)),
    ((-0.9, 0.06, -0.42), (0.9, 0.85, -0.22)),
]
FRAME = boxes(((-0.9, 0.06, -0.42), (0.9, 0.26, 0.42)), ((-0.9, 0.06, -0.42), (0.9, 0.85, -0.22)))
CUSHION = boxes(((-0.74, 0.265, -0.21), (0.74, 0.43, 0.42)))
PILLOW = boxes(((-0.2, 0.44, -0.2), (0.25, 0.56, 0.2)))
TABLE = boxes(((-0.7, 0.7, 0.6), (0.7, 0.74, 1.4)))
PLATE = boxes(((-0.1, 0.44, 0.1), (0.1, 0.46, 0.3)))


def scene(**objects):
    return SceneGeometry.from_objects(objects.items())


@pytest.mark.parametrize(
    ("named", "others", "expected"),
    [
        ("frame", {"frame": FRAME, "cushion": CUSHION, "floor": FLOOR}, {"cushion"}),
        ("cushion", {"frame": FRAME, "cushion": CUSHION, "floor": FLOOR}, {"frame"}),
        ("cushion", {"frame": FRAME, "cushion": CUSHION, "pillow": PILLOW}, {"frame", "pillow"}),
        ("frame", {"frame": FRAME, "floor": FLOOR, "table": TABLE}, set()),
        ("cushion", {"cushion": CUSHION, "plate": PLATE, "floor": FLOOR}, set()),
    ],
    ids=[
        "cushion on frame",
        "frame under cushion",
        "pillow on both",
        "a table beside",
        "a plate is in the way",
    ],
)
def test_what_rests_on_a_target_belongs_to_it(named, others, expected):
    assert set(belongings(scene(**others), [named])) == expected


BED = boxes(((-0.7, 0, -1.0), (0.7, 0.45, 1.0)))


@pytest.mark.parametrize("turn", [0.0, 0.6])
@pytest.mark.parametrize(
    ("board", "belongs"),
    [
        (((-0.75, 0.0, -1.08), (0.75, 1.0, -1.01)), True),
        (((-1.2, 0.4, -1.08), (1.2, 1.1, -1.0)), True),
        (((-0.6, 0.5, 1.0), (0.6, 0.8, 1.05)), True),
        (((-2.0, 0.0, -1.1), (2.0, 2.6, -1.0)), False),
        (((-0.75, 0.0, -1.6), (0.75, 1.0, -1.5)), False),
        (((0.72, 0.0, -1.0), (1.1, 0.6, -0.6)), False),
        (((-0.75, 0.0, -1.08), (0.75, 0.5, -1.01)), False),
    ],
    ids=[
        "headboard",
        "wide board on a wall",
        "footboard",
        "wall",
        "away from it",
        "night table",
        "as low as the bed",
    ],
)
def test_a_separate_headboard_belongs_to_its_bed(board, belongs, turn):
    turned = frames.yawed_axes(turn).T
    whole = scene(bed=BED @ turned, board=boxes(board) @ turned, floor=FLOOR)
    assert belongings(whole, ["bed"]) == (("board",) if belongs else ())


@pytest.mark.parametrize("end", [-1, 1])
def test_the_head_is_at_a_separate_headboard(end):
    board = boxes(((-0.75, 0, -1.08), (0.75, 1.0, -1.01))) * [1, 1, -end]
    whole = scene(bed=BED, board=board, floor=FLOOR)
    names = ("bed", *belongings(whole, ["bed"]))
    best = seats.find_goals(whole.triangles_of(names), "lie")[0]
    assert best.direction[2] == pytest.approx(-end, abs=0.1)


def test_characters_never_belong_to_furniture():
    assert belongings(scene(frame=FRAME, pillow=PILLOW, cushion=CUSHION), ["frame"], ["cushion"]) == ()


def test_a_room_of_one_mesh_is_split():
    walls = boxes(((-4, 0, -4.1), (4, 2.6, -4)), ((-4.1, 0, -4), (-4, 2.6, 4)))
    sofa = boxes(*SOFA) + [0, 0, -2]
    low_table = boxes(((-0.5, 0, 0.5), (0.5, 0.35, 1.0)))
    whole = scene(room=np.concatenate([FLOOR, walls, low_table, sofa]))
    assert parts.is_room(whole.triangles, whole.object_ids)
    found = whole.triangles[room.choose(whole, ["room"], "sit")]
    assert np.allclose(geometry.extent(found), geometry.extent(sofa))
    hinted = whole.triangles[room.choose(whole, ["room"], "sit", hint=np.array([0, 0.3, 0.8]))]
    assert np.allclose(geometry.extent(hinted), geometry.extent(low_table))


def chair(at):
    """Return the boxes of a chair, facing -Z, whose back is at z = 0.2."""
    legs = [((x, 0, z), (x + 0.04, 0.4, z + 0.04)) for x in (-0.2, 0.16) for z in (-0.2, 0.16)]
    whole = [((-0.2, 0.4, -0.2), (0.2, 0.45, 0.2)), ((-0.2, 0.45, 0.16), (0.2, 0.9, 0.2)), *legs]
    return boxes(*whole) + [at[0], 0, at[1]]


@pytest.mark.parametrize(
    ("hint", "meant"),
    [
        ((0.0, 0.45, 0.35), "near"),
        ((-0.1, 0.8, 0.48), "near"),
        ((0.74, 0.2, -0.28), "far"),
        ((0.0, 0.74, 0.0), "table"),
    ],
    ids=["a seat under the table", "a back", "a leg", "the table's top"],
)
def test_a_click_tells_chairs_from_their_table(hint, meant):
    legs = [((x, 0, z), (x + 0.05, 0.7, z + 0.05)) for x in (-0.6, 0.55) for z in (-0.35, 0.3)]
    pieces = {
        "table": boxes(((-0.65, 0.7, -0.4), (0.65, 0.74, 0.4)), *legs),
        "near": chair((0, 0.32)),
        "far": chair((0.92, -0.1)),
    }
    whole = scene(room=np.concatenate([FLOOR, *pieces.values()]))
    chosen = whole.triangles[room.choose(whole, ["room"], "sit", hint=np.array(hint))]
    assert np.allclose(geometry.extent(chosen), geometry.extent(pieces[meant]))


@pytest.mark.parametrize(
    ("base", "expected"),
    [(boxes(((-1.5, 0, -1), (1.5, 0.05, 1))), True), (boxes(((-0.9, 0, -0.45), (0.9, 0.05, 0.45))), False)],
    ids=["a diorama on its floor", "a sofa on a plinth"],
)
def test_a_diorama_is_a_room(base, expected):
    whole = scene(base=base, sofa=boxes(*SOFA))
    assert parts.is_room(whole.triangles, whole.object_ids) == expected


def test_scattered_blades_are_left_out():
    blade = np.array([(0, 0, 0), (0.01, 0, 0), (0, 0.1, 0.02)])
    points = np.concatenate([blade + [k % 20 * 0.1, 0, k // 20 * 0.1] for k in range(400)])
    corners = np.arange(1200).reshape(-1, 3)
    assert scatter.is_tiny(blade, np.array([[0, 1, 2]]), 1.0)
    assert len(scatter.without_blades(points, corners, 1.0)) == 0
    assert len(scatter.without_blades(points, corners, 100.0)) == 400


def test_furniture_of_triangles_apart_is_not_scattered():
    axis = np.linspace(0, 0.5, 21)
    low, high = np.meshgrid(axis[:-1], axis[:-1]), np.meshgrid(axis[1:], axis[1:])
    corner = lambda x, z: np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], axis=1)
    seat = np.stack([corner(low[0], low[1]), corner(high[0], low[1]), corner(high[0], high[1])], axis=1)
    points = np.concatenate([seat.reshape(-1, 3), seat.reshape(-1, 3) * [1, 1, 1]])
    corners = np.arange(len(points)).reshape(-1, 3)
    assert len(scatter.without_blades(points, corners, 1.0)) == len(corners)


@pytest.mark.parametrize(
    ("target", "others", "floor"),
    [
        (boxes(*SOFA), FLOOR, None),
        (boxes(((-0.6, 0.4, -0.2), (0.6, 0.45, 0.2))), FLOOR, 0.0),
        (boxes(*SOFA) + [0, 0.2, 0], np.concatenate([FLOOR, boxes(((-2, 0, -2), (2, 0.2, 2)))]), None),
        (CUSHION + [0, 0.2, 0], np.concatenate([FLOOR, boxes(((-2, 0, -2), (2, 0.2, 2)))]), 0.2),
    ],
    ids=["on its feet", "a wall bench", "on a platform", "a cushion over a platform"],
)
def test_heights_are_those_over_the_floor_beside(target, others, floor):
    mesh = navmesh.build(np.concatenate([others, target]))
    found = floor_beside(mesh, target)
    assert found is None if floor is None else found == pytest.approx(floor, abs=0.03)
    assert seats.find_goals(target, "sit", found)


@pytest.mark.parametrize(
    ("between", "passes"),
    [(boxes(((-3, 0, 0.5), (3, 0.9, 0.56))), False), (boxes(((-3, 1.2, 0.5), (3, 1.5, 0.56))), True)],
    ids=["a low back", "a beam overhead"],
)
def test_low_backs_are_walls_and_beams_are_not(between, passes):
    bench = boxes(((-3, 0, -0.2), (3, 0.45, 0.2)))
    wall = boxes(
        ((-4, 0, -0.5), (4, 2.5, -0.4)), ((-3.1, 0, -0.4), (-3, 2.5, 0.6)), ((3, 0, -0.4), (3.1, 2.5, 0.6))
    )
    mesh = navmesh.build(np.concatenate([FLOOR, bench, between, wall]))
    goal = Goal(np.array([0, 0.63, 0.0]), np.array([0, 0, 1.0]), "sit")
    if passes:
        assert path.plan_to_goal(mesh, np.array([0, 0, 2.0]), goal).length > 0.5
    else:
        with pytest.raises(PathError):
            path.plan_to_goal(mesh, np.array([0, 0, 2.0]), goal)


def test_nobody_sits_on_the_back_of_a_covered_sofa():
    sofa = boxes(SOFA[0], ((-0.9, 0.06, -0.42), (0.9, 0.83, -0.1)))
    crates = boxes(((-0.9, 0.44, -0.08), (0.9, 0.8, 0.42)))
    assert seats.find_seats(sofa, "sit")[0].surface == pytest.approx(0.43, abs=0.1)
    assert seats.find_goals(sofa, "sit", obstacles=crates) == []


def test_a_seat_with_a_hole():
    ring = boxes(
        ((-0.19, 0.38, -0.2), (-0.11, 0.42, 0.24)),
        ((0.11, 0.38, -0.2), (0.19, 0.42, 0.24)),
        ((-0.11, 0.38, 0.17), (0.11, 0.42, 0.24)),
        ((-0.11, 0.38, -0.2), (0.11, 0.42, -0.12)),
        ((-0.13, 0, -0.2), (0.13, 0.2, 0.18)),
        ((-0.2, 0.3, -0.4), (0.2, 0.8, -0.2)),
    )
    found = seats.find_goals(ring, "sit")
    assert found and found[0].direction[2] > 0.9


def test_the_field_of_a_large_scene_is_that_of_a_small_one():
    box = boxes(((-0.5, 0, -0.5), (0.5, 0.4, 0.5)))
    free = np.array([[0.0, 1.0, 1.0], [0.0, 0.8, 1.2]])
    points = np.array([[0.0, 0.35, 0.0], [0.0, 0.44, 0.1], [0.6, 0.05, 0.6]])
    small = np.concatenate([boxes(((-3, -0.1, -3), (3, 0, 3))), box])
    large = np.concatenate([boxes(((-1000, -0.1, -1000), (1000, 0, 1000))), box])
    fields = [signed_distance.cached_field(triangles, free) for triangles in (small, large)]
    assert fields[1].memory < 50e6
    depths = [field.at(points)[0] for field in fields]
    assert np.allclose(*depths, atol=0.005)


def test_map_coordinates_are_told():
    with pytest.raises(SampError, match="origin"):
        scene(floor=FLOOR + [5.4e6, 0, 0])
