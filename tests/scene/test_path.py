"""Paths: short, clear of obstacles, over stairs, and errors where there is none."""

from __future__ import annotations

import heapq
from pathlib import Path as File

import numpy as np
import pytest
from samp_blender.samp_addon.errors import PathError
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.scene.navmesh import navmesh, path
from samp_blender.samp_addon.scene.navmesh.navmesh import Agent
from samp_blender.tests.support import layouts

FURNITURE = File(__file__).parents[3] / "shared" / "data" / "furniture"
ROOM = np.concatenate([layouts.floor(8, 8), layouts.walls(8)])


def join(*parts):
    return np.concatenate(parts)


def along(waypoints, spacing=0.02):
    """Return points (M, 3) along a path."""
    pieces = [
        a + np.linspace(0, 1, int(np.linalg.norm(b - a) / spacing) + 2)[:, None] * (b - a)
        for a, b in zip(waypoints, waypoints[1:], strict=False)
    ]
    return np.concatenate(pieces or [waypoints])


def clearance(waypoints, obstacles, height=(0.3, 1.7)):
    """Return the smallest horizontal distance of a path from samples of obstacles at the body's height."""
    from samp_blender.samp_addon.scene import geometry

    samples = geometry.sample_surface(obstacles, 60_000)[0]
    samples = samples[(samples[:, 1] > height[0]) & (samples[:, 1] < height[1])][:, [0, 2]]
    points = along(waypoints)[:, [0, 2]]
    return min(np.linalg.norm(samples - p, axis=1).min() for p in points)


class VisibilityGraph:
    """Shortest paths around boxes, exact up to the number of corners: the reference."""

    def __init__(self, boxes, radius, corners=16):
        self.boxes, self.radius = boxes, radius
        turn = np.linspace(0, 2 * np.pi, corners, endpoint=False)
        # Circumscribed, so that the straight edges between the corners stay outside of the radius.
        ring = np.stack([np.cos(turn), np.sin(turn)], 1) * (radius + 1e-6) / np.cos(np.pi / corners)
        nodes = [
            centre + ((np.array([sx, sz]) * half)[None] + ring) @ turned.T
            for centre, half, turned in boxes
            for sx in (-1, 1)
            for sz in (-1, 1)
        ]
        self.nodes = np.concatenate(nodes)
        self.nodes = self.nodes[self.free(self.nodes)]

    def free(self, points, slack=1e-9):
        good = (np.abs(points) <= 4 - self.radius).all(-1)
        for centre, half, turned in self.boxes:
            local = (points - centre) @ turned
            gap = np.linalg.norm(np.maximum(np.abs(local) - half, 0), axis=-1)
            good &= gap >= self.radius - slack
        return good

    def length(self, start, goal):
        nodes = np.concatenate([[start, goal], self.nodes])
        best, queue = np.full(len(nodes), np.inf), [(0.0, 0)]
        best[0] = 0
        done = np.zeros(len(nodes), dtype=bool)
        share = np.linspace(0, 1, 160)[None, :, None]
        while queue:
            _, here = heapq.heappop(queue)
            if here == 1:
                return best[1]
            if done[here]:
                continue
            done[here] = True
            lines = nodes[here] + share * (nodes[:, None] - nodes[here])
            visible = self.free(lines.reshape(-1, 2), 2e-3).reshape(len(nodes), -1).all(1)
            total = best[here] + np.linalg.norm(nodes - nodes[here], axis=1)
            for k in np.flatnonzero(visible & (total < best - 1e-9)):
                best[k] = total[k]
                heapq.heappush(queue, (total[k] + np.linalg.norm(nodes[k] - nodes[1]), k))
        return np.inf


def crowded(seed):
    """Return a room of rotated boxes: (centre, half sides, rotation) for the reference, and triangles."""
    rng = np.random.default_rng(seed)
    boxes, triangles = [], [ROOM]
    for _ in range(8):
        centre, half, yaw = rng.uniform(-3, 3, 2), rng.uniform(0.2, 0.7, 2), rng.uniform(0, np.pi)
        forward, left = (np.sin(yaw), np.cos(yaw)), (np.cos(yaw), -np.sin(yaw))
        boxes.append((centre, half, np.array([left, forward]).T))
        block = layouts.box((-half[0], 0, -half[1]), (half[0], 1.2, half[1]))
        triangles.append(layouts.moved(block, yaw, (centre[0], 0, centre[1])))
    return boxes, np.concatenate(triangles)


@pytest.mark.parametrize("seed", range(6))
def test_paths_are_within_five_percent_of_a_visibility_graph(seed):
    agent = Agent(radius=0.22)
    boxes, triangles = crowded(seed)
    mesh = navmesh.build(triangles, agent)
    reference = VisibilityGraph(boxes, agent.radius)
    rng = np.random.default_rng(seed)
    island = mesh.island_of(mesh.nearest(np.zeros(3)))
    places = mesh.points[mesh.island_of(mesh.walkable) == island]
    places = places[places[:, 1] < 0.1]
    ratios = []
    for _ in range(6):
        start, goal = places[rng.integers(len(places), size=2)]
        best = reference.length(start[[0, 2]], goal[[0, 2]])
        if np.isfinite(best) and best > 1.5:
            found = path.plan(mesh, start, goal)
            ratios.append(found.length / best)
            # The reference is polygonal around corners, so that it may be slightly longer than the shortest path.
            assert path.plan(mesh, start, goal, comfort=0).length / best < 1.05
            assert clearance(found.waypoints, triangles[len(ROOM) :]) > agent.radius - 0.01
    assert len(ratios) > 2 and max(ratios) < 1.05 and min(ratios) > 0.99


@pytest.mark.parametrize(("width", "passable"), [(0.7, True), (0.6, True), (0.4, False)])
@pytest.mark.parametrize("yaw", [0.0, 0.5, np.pi / 4])
def test_doorways(width, passable, yaw):
    wall = [layouts.box((x0, 0, -0.05), (x1, 2.6, 0.05)) for x0, x1 in ((-4, -width / 2), (width / 2, 4))]
    lintel = layouts.box((-width / 2, 2.0, -0.05), (width / 2, 2.6, 0.05))
    triangles = join(layouts.floor(5, 5), layouts.moved(join(*wall, lintel), yaw))
    mesh = navmesh.build(triangles)
    start, goal = (layouts.moved(np.array([[0, 0, z]]), yaw)[0] for z in (-1.5, 1.5))
    if passable:
        found = path.plan(mesh, start, goal)
        assert 3.0 - 1e-6 <= found.length < 3.1
        assert clearance(found.waypoints, triangles) > 0.2
    else:
        with pytest.raises(PathError, match="No way leads"):
            path.plan(mesh, start, goal)


def test_paths_lead_up_and_down_stairs():
    upstairs = layouts.floor(6, 3, layouts.STOREY, by=(0, 5.7))
    triangles = join(layouts.floor(6, 14), upstairs, layouts.stairs(15, 0.2, 0.28))
    mesh = navmesh.build(triangles)
    start, goal = np.array([2.5, 0, 6.0]), np.array([-2.0, layouts.STOREY, 5.7])
    up = path.plan(mesh, start, goal)
    np.testing.assert_allclose(up.waypoints[[0, -1]], [start, goal], atol=0.03)
    line = along(up.waypoints)
    on_stairs = (line[:, 2] > 0.3) & (line[:, 2] < 3.9) & (line[:, 1] > 0.3)
    assert on_stairs.any() and (np.abs(line[on_stairs, 0]) < 0.6).all()
    slope = line[on_stairs, 2] / 0.28 * 0.2 + 0.1
    assert np.abs(line[on_stairs, 1] - slope).max() < 0.25
    down = path.plan(mesh, goal, start)
    assert abs(down.length - up.length) < 0.02 * up.length


def test_paths_follow_the_ground_over_a_ramp():
    mesh = navmesh.build(join(layouts.floor(8, 12), layouts.ramp(25)))
    found = path.plan(mesh, np.array([0, 0, -2.0]), np.array([0, 1.5, 4.5]))
    line, run = along(found.waypoints), 1.5 / np.tan(np.radians(25))
    ground = np.clip(line[:, 2] / run, 0, 1) * 1.5
    assert np.abs(line[:, 1] - ground).max() < 0.14
    assert 3 <= len(found.waypoints) <= 8


def test_paths_avoid_climbing():
    toy_box = layouts.box((-0.5, 0, -0.5), (0.5, 0.2, 0.5))
    mesh = navmesh.build(join(layouts.floor(), toy_box))
    found = path.plan(mesh, np.array([0, 0, -2.0]), np.array([0, 0, 2.0]))
    assert found.waypoints[:, 1].max() < 0.05 and clearance(found.waypoints, toy_box, (0, 1)) > 0.1
    doorstep = layouts.box((-3, 0, -0.5), (3, 0.2, 0.5))
    across = path.plan(navmesh.build(join(layouts.floor(), doorstep)), [0, 0, -2.0], [0, 0, 2.0])
    assert across.length < 4.6 and across.waypoints[:, 1].max() == pytest.approx(0.2, abs=0.03)


@pytest.mark.parametrize(
    ("start", "goal", "ends"),
    [
        ((0, 0, -3), (0, 0, 3), ((0, -3), (0, 3))),
        ((0, 0.95, -3), (0, 0.95, 3), ((0, -3), (0, 3))),
        ((3.95, 0, 0), (0, 0, 3), ((3.76, 0), (0, 3))),
        ((0, 0, -3), (0, 0.5, 0.2), ((0, -3), (0, 0.62))),
    ],
)
def test_ends_off_the_mesh_are_moved_onto_it(start, goal, ends):
    mesh = navmesh.build(join(ROOM, layouts.box((-1, 0, -0.4), (1, 0.45, 0.4))))
    found = path.plan(mesh, np.array(start, dtype=float), np.array(goal, dtype=float)).waypoints
    np.testing.assert_allclose(found[[0, -1]][:, [0, 2]], ends, atol=0.05)
    np.testing.assert_allclose(found[[0, -1], 1], 0, atol=0.03)


CAGE = join(
    *(layouts.moved(layouts.box((-1, 0, 0.9), (1, 2, 1)), k * np.pi / 2, (2, 0, 2)) for k in range(4))
)

WIDE_CAGE = join(*(layouts.moved(layouts.box((-2, 0, 1.9), (2, 2, 2)), k * np.pi / 2) for k in range(4)))


@pytest.mark.parametrize(
    ("start", "goal", "words"),
    [
        ((30, 0, 0), (0, 0, 0), "start is"),
        ((0, 0, 0), (0, 0, 30), "goal is"),
        ((0, 0, 0), (2, 0, 2), "No way leads"),
        ((2, 0, 2), (0, 0, 0), "No way leads"),
    ],
)
def test_unreachable_goals_raise_an_error(start, goal, words):
    mesh = navmesh.build(join(ROOM, CAGE))
    with pytest.raises(PathError, match=words) as error:
        path.plan(mesh, np.array(start, dtype=float), np.array(goal, dtype=float))
    assert str(error.value).count(".") >= 1 and "\n" not in str(error.value)


def seat_goal(by, yaw, action="sit"):
    facing = np.array([np.sin(yaw), 0, np.cos(yaw)])
    return Goal(np.array([by[0], 0.55, by[1]]) + 0.1 * facing, facing, action)


@pytest.mark.parametrize("yaw", np.linspace(0, 2 * np.pi, 7)[:-1])
def test_paths_to_seats_end_in_front_of_them(yaw):
    mesh = navmesh.build(join(ROOM, layouts.sofa((0.5, 0.3), yaw)))
    goal = seat_goal((0.5, 0.3), yaw)
    for start in ((-3, 0, -3), (3, 0, 3), (3, 0, -3)):
        found = path.plan_to_goal(mesh, np.array(start, dtype=float), goal)
        offset = found.waypoints[-1] - goal.position
        across = np.array([offset[0], 0, offset[2]])
        assert across @ goal.direction > 0.9 * np.linalg.norm(across)
        assert 0.45 < np.linalg.norm(across) < 0.8
        assert clearance(found.waypoints, layouts.sofa((0.5, 0.3), yaw), (0.1, 1.5)) > 0.2


def test_a_seat_at_a_table_is_approached_from_the_side():
    chair = layouts.sofa((0, 0), 0.0, width=0.5)
    mesh = navmesh.build(join(ROOM, chair, layouts.table((0, 0.8))))
    goal = seat_goal((0, 0), 0.0)
    end = path.plan_to_goal(mesh, np.array([-3.0, 0, 2]), goal).waypoints[-1]
    offset = end - goal.position
    assert np.hypot(offset[0], offset[2]) < path.REACH and offset[2] > -0.4


def test_a_seat_is_not_approached_through_a_thin_wall():
    wall = layouts.box((-4, 0, -0.5), (2, 2.6, -0.42))
    mesh = navmesh.build(join(ROOM, layouts.sofa(), wall, layouts.box((-4, 0, 0.65), (2, 1.5, 0.75))))
    goal = seat_goal((0, 0), 0.0)
    end = path.plan_to_goal(mesh, np.array([0.0, 0, -3]), goal).waypoints[-1]
    assert end[2] > -0.5


@pytest.mark.parametrize(
    ("obstacles", "words"),
    [
        (layouts.box((-2.5, 0, -2.5), (2.5, 0.9, 2.5)), "no free floor"),
        (WIDE_CAGE, "No way"),
    ],
)
def test_unreachable_seats_raise_an_error(obstacles, words):
    mesh = navmesh.build(join(ROOM, layouts.sofa(), obstacles))
    with pytest.raises(PathError, match=words):
        path.plan_to_goal(mesh, np.array([3.2, 0, 3.2]), seat_goal((0, 0), 0.0))


def test_wide_beds_have_a_larger_reach():
    mesh = navmesh.build(join(ROOM, layouts.box((-1.1, 0, -1), (1.1, 0.5, 1))))
    found = path.plan_to_goal(mesh, np.array([3.0, 0, 3]), seat_goal((0, 0), 0.0, "lie"))
    assert 1.1 < np.hypot(*found.waypoints[-1][[0, 2]]) < 2


@pytest.mark.skipif(not FURNITURE.exists(), reason="the furniture files are not available")
@pytest.mark.parametrize("seed", range(4))
def test_paths_avoid_real_furniture(seed):
    from samp_blender.training.furniture import library

    rng = np.random.default_rng(seed)
    files = sorted(FURNITURE.glob("*.glb"))
    places = [(x, z) for x in (-2.2, 0, 2.2) for z in (-2.2, 0, 2.2)]
    pieces = []
    for k in rng.permutation(len(places))[:6]:
        piece = library.read_glb(files[rng.integers(len(files))])
        low, high = piece.min((0, 1)), piece.max((0, 1))
        piece = (piece - [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2]) * min(
            1, 1.4 / max(high[0] - low[0], high[2] - low[2])
        )
        pieces.append(layouts.moved(piece, rng.uniform(0, 2 * np.pi), (places[k][0], 0, places[k][1])))
    mesh = navmesh.build(join(ROOM, *pieces))
    found = path.plan(mesh, np.array([-3.6, 0, -3.6]), np.array([3.6, 0, 3.6]))
    assert 10.1 < found.length < 13
    assert clearance(found.waypoints, join(*pieces)) > 0.2
