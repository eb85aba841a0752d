"""Groups of furniture: tables with their seats, desks, bars, beds, objects on tops."""

from __future__ import annotations

import numpy as np

from ...furniture import shapes
from ..classes import Part
from . import clutter
from . import storage as cupboards
from .floorplan import Placed, Plan, Rectangle, turned
from .stock import Item, Stock

LEG_ROOM = 0.5  # metres in front of a seat that stay free


def item_of(name: str, parts: list[Part]) -> Item:
    """Return a procedural item, whose name is its category."""
    return Item(name, name, parts)


def opposite(placed: Placed) -> list[int]:
    """Return the number of the wall that an item faces, as a list."""
    yaws = np.array([0.0, np.pi / 2, np.pi, -np.pi / 2])
    return [int(np.argmin(np.cos(yaws - placed.yaw)))]


def low_table(plan: Plan, stock: Stock, sofa: Placed) -> None:
    """Place a low table in front of a sofa in most cases."""
    rng = plan.rng
    item = stock.pick(rng, "low_table", most=max(1.0, 0.8 * sofa.item.size[0]))
    if item is None or rng.random() < 0.15:
        return
    reach = sofa.item.box[1][2] + rng.uniform(0.42, 0.65) + item.size[2] / 2
    x, z = sofa.at(rng.uniform(-0.25, 0.25), reach)
    plan.put(item, x, z, sofa.yaw + rng.choice([0.0, 0.0, rng.uniform(-0.2, 0.2)]))


def beside_table(plan: Plan, stock: Stock, sofa: Placed) -> None:
    """Place seats at both sides of the area in front of a sofa, facing each other."""
    rng = plan.rng
    ahead = sofa.item.box[1][2] + rng.uniform(0.6, 0.9)
    for side in (-1, 1):
        item = stock.pick(rng, "armchair", "armchair", "chair", "pouf")
        if item is None or rng.random() < 0.35:
            continue
        x, z = sofa.at(side * (sofa.item.size[0] / 2 + rng.uniform(0.3, 0.6)), ahead)
        placed = plan.put(item, x, z, sofa.yaw - side * np.pi / 2 + rng.uniform(-0.4, 0.4))
        if placed is not None:
            plan.keep_front(placed, LEG_ROOM)


def free_seat(plan: Plan, item: Item | None, front: float = LEG_ROOM) -> Placed | None:
    """Place a seat along a wall; return it, or None."""
    return plan.along_wall(item, gap=plan.rng.uniform(0.03, 0.25), front=front)


def rug(plan: Plan, centre: np.ndarray, yaw: float, scale: float = 1.0) -> None:
    """Place a rug near a centre (2,), metres, in most cases."""
    rng = plan.rng
    if rng.random() < 0.35:
        return
    x, z = scale * rng.uniform(0.7, 1.4), scale * rng.uniform(0.5, 1.0)
    rug = item_of("rug", [Part("floor", shapes.box((-x, 0.0, -z), (x, 0.004, z)))])
    room = np.array(plan.shell.size[:2]) / 2 - np.abs(turned(np.array([x, z]), yaw)) - 0.05
    if (room > 0).all():
        x, z = np.clip(centre, -room, room)
        plan.placed.append(Placed(rug, float(x), 0.0, float(z), yaw))


def storage(plan: Plan, names: list[str], count: int) -> None:
    """Place up to ``count`` pieces of storage, builders of storage.py by name, along the walls."""
    for name in plan.rng.permutation(names)[:count]:
        parts = getattr(cupboards, str(name))(plan.rng)
        plan.along_wall(item_of(str(name), parts), front=0.35)


def keep_beside(plan: Plan, bed: Placed, side: int) -> None:
    """Keep a strip beside a bed free, if there is room for one."""
    low, high = bed.item.box
    x = (high[0] + 0.3) if side > 0 else (low[0] - 0.3)
    strip = Rectangle(
        bed.at(x, (low[2] + high[2]) / 2 + 0.25), np.array([0.27, (high[2] - low[2]) / 2 - 0.25]), bed.yaw
    )
    if plan.fits(strip, 0.0):
        plan.kept.append(strip)


def desk(plan: Plan, stock: Stock, seats: tuple[str, ...]) -> None:
    """Place a desk that faces the room, with a chair pulled out."""
    rng = plan.rng
    item = stock.pick(rng, "desk", "table", most=2.0)
    desk = plan.along_wall(item, gap=rng.uniform(0.02, 0.1))
    if desk is None:
        return
    chair = stock.pick(rng, *seats)
    if chair is not None:
        pulled = desk.item.box[1][2] + rng.uniform(0.1, 0.5) + chair.size[2] / 2
        x, z = desk.at(rng.uniform(-0.25, 0.25), pulled)
        plan.put(chair, x, z, desk.yaw + np.pi + rng.normal(0, 0.5))
    plan.keep_front(desk, 1.1)
    put_on(plan, desk, "office", int(rng.integers(1, 5)))


def table_group(
    plan: Plan, stock: Stock, tables: tuple[str, ...], seats: tuple[str, ...], most: int, centre: bool = False,
    seat: Item | None = None,
) -> Placed | None:  # fmt: skip
    """Place a table with seats around it, most of them pulled out far enough for sitting; return it, or None."""
    rng = plan.rng
    width, depth, _ = plan.shell.size
    item = stock.pick(rng, *tables, most=0.6 * max(width, depth))
    seat = seat or stock.pick(rng, *seats, most=1.5)
    if item is None or seat is None:
        return None
    table = None
    for _ in range(20):
        reach = np.array([width, depth]) / 2 - 0.5 - item.size[[0, 2]].max() / 2
        spread = 0.35 if centre else 1.0
        place = rng.uniform(-1, 1, 2) * spread * np.maximum(reach, 0)
        table = plan.put(
            item, *place, rng.choice([0, np.pi / 2]) + rng.choice([0.0, rng.normal(0, 0.15)]), air=0.55
        )
        if table is not None:
            break
    if table is None:
        return None
    sides = rng.permutation(4)
    for side in sides:
        yaw = side * np.pi / 2
        along, out = (item.size[0], item.size[2]) if side % 2 == 0 else (item.size[2], item.size[0])
        count = max(int(along / (seat.size[0] + 0.15)), 1)
        for at in (np.arange(count) - (count - 1) / 2) * along / count:
            if most <= 0 or rng.random() < 0.2:
                continue
            pulled = (
                out / 2
                + seat.box[1][2]
                + rng.choice([rng.uniform(-0.15, 0.1), rng.uniform(0.2, 0.55)], p=[0.2, 0.8])
            )
            local = turned(np.array([at, pulled]), yaw)
            turn = rng.normal(0, 0.25 if pulled > out / 2 + 0.4 else 0.08)
            if plan.put(seat, *table.at(*local), table.yaw + yaw + np.pi + turn, air=0.01) is not None:
                most -= 1
    return table


def bar_stools(plan: Plan, stock: Stock, bar: Placed | None) -> None:
    """Place stools in front of a bar."""
    rng = plan.rng
    stool = stock.pick(rng, "bar_stool")
    if bar is None or stool is None:
        return
    for x in np.arange(-bar.item.size[0] / 2 + 0.35, bar.item.size[0] / 2 - 0.3, 0.65):
        if rng.random() < 0.75:
            place = bar.at(x, bar.item.box[1][2] + stool.box[1][2] + rng.uniform(0.1, 0.4))
            plan.put(stool, *place, bar.yaw + np.pi + rng.normal(0, 0.3), air=0.01)
    plan.keep_front(bar, 1.2)


def put_on(plan: Plan, below: Placed, kind: str, count: int) -> None:
    """Place objects on a table or a cupboard."""
    rng = plan.rng
    low, high = below.item.box
    for _ in range(count):
        build = clutter.ON_TABLE[kind][rng.integers(len(clutter.ON_TABLE[kind]))]
        room = np.maximum((high - low)[[0, 2]] / 2 - 0.08, 0.02)
        place = (low + high)[[0, 2]] / 2 + rng.uniform(-1, 1, 2) * room
        turn = rng.normal(0, 0.3) if build in (clutter.monitor, clutter.laptop) else rng.uniform(0, 6.28)
        plan.on_top(below, item_of(build.__name__, build(rng)), tuple(place), turn)
