"""The seven kinds of rooms: what stands in them and how it stands to each other."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...furniture import shapes
from ..classes import Part
from . import clutter, storage
from .floorplan import Placed, Plan, turned
from .stock import Item, Stock

LEG_ROOM = 0.5  # metres in front of a seat that stay free
Rng = np.random.Generator


def thing(name: str, parts: list[Part]) -> Item:
    """A procedural item."""
    return Item(name, name, parts)


def living(plan: Plan, stock: Stock) -> None:
    """Sofas and armchairs about a low table, a screen opposite, shelves."""
    rng = plan.rng
    sofa = plan.along_wall(
        stock.pick(rng, "sofa", "sofa", "l_sofa", most=0.8 * max(plan.shell.size[:2])),
        gap=rng.uniform(0.02, 0.12),
    )
    if sofa is None:
        sofa = plan.along_wall(stock.pick(rng, "sofa", "armchair", most=1.7), gap=0.03)
    if sofa is not None:
        _low_table(plan, stock, sofa)
        _beside_table(plan, stock, sofa)
        plan.keep_front(sofa, LEG_ROOM)
        _rug(plan, sofa.at(0.0, sofa.item.box[1][2] + 0.6), sofa.yaw)
        screen = thing("screen", storage.board(rng, "screen"))
        low = plan.along_wall(thing("sideboard", storage.sideboard(rng)), _opposite(sofa), front=0.4)
        if low is not None:
            y = low.item.box[1][1]
            base = Placed(screen, *low.at(0.0, 0.1)[:1], y + 0.04, low.at(0.0, 0.1)[1], low.yaw)
            plan.placed.append(base)
    for category in rng.permutation(["armchair", "pouf", "chair", "sofa"])[: int(rng.integers(1, 4))]:
        _free_seat(plan, stock.pick(rng, str(category), most=2.2))
    _storage(plan, ["bookshelf", "bookshelf", "sideboard", "drawers"], int(rng.integers(1, 4)))
    if plan.shell.size[0] * plan.shell.size[1] > 22 and rng.random() < 0.6:
        _table_group(plan, stock, ("table", "small_table"), ("chair",), 4)


def bedroom(plan: Plan, stock: Stock) -> None:
    """One bed or two, nightstands, wardrobes, a chair or a desk."""
    rng = plan.rng
    for number in range(2 if rng.random() < 0.25 else 1):
        bed = plan.along_wall(stock.pick(rng, "bed"), gap=0.03, air=0.35 if number == 0 else 0.1)
        if bed is None:
            continue
        low, high = bed.item.box
        for side in (-1, 1):
            stand = thing("nightstand", storage.nightstand(rng))
            x = high[0] + stand.size[0] / 2 + 0.05 if side > 0 else low[0] - stand.size[0] / 2 - 0.05
            if rng.random() < 0.8:
                plan.put(stand, *bed.at(x, low[2] + 0.03), bed.yaw, air=0.0)
        for side in (-1, 1):
            _keep_beside(plan, bed, side)
        _rug(plan, bed.at(0.0, high[2]), bed.yaw)
    _storage(plan, ["wardrobe", "drawers", "wardrobe"], int(rng.integers(1, 3)))
    if rng.random() < 0.6:
        _desk(plan, stock, ("chair", "office_chair"))
    for category in rng.permutation(["armchair", "bench", "pouf", "chair", "lounger"])[
        : int(rng.integers(1, 3))
    ]:
        _free_seat(plan, stock.pick(rng, str(category), most=2.1))


def dining(plan: Plan, stock: Stock) -> None:
    """A table with chairs in the middle, sideboards along the walls."""
    rng = plan.rng
    table = _table_group(
        plan, stock, ("table", "table", "small_table", "desk"), ("chair", "chair", "bench"), 8, centre=True
    )
    if table is not None and rng.random() < 0.6:
        _rug(plan, table.at(0, 0), table.yaw, 1.3)
    _storage(plan, ["sideboard", "drawers", "bookshelf", "sideboard"], int(rng.integers(1, 4)))
    for category in rng.permutation(["armchair", "sofa", "bench"])[: int(rng.integers(0, 3))]:
        _free_seat(plan, stock.pick(rng, str(category), most=2.0))


def kitchen(plan: Plan, stock: Stock) -> None:
    """A counter along one wall or two, a fridge, a table with chairs or stools."""
    rng = plan.rng
    longest = max(plan.shell.size[:2])
    for number in range(1 if rng.random() < 0.5 else 2):
        width = min(rng.uniform(1.6, 3.4) if number == 0 else rng.uniform(1.0, 2.0), longest - 0.5)
        run = thing("counter", storage.counter(rng, width, rng.random() < 0.7))
        placed = plan.along_wall(run, gap=0.0, front=0.7, corner=number == 0 and rng.random() < 0.7)
        if placed is not None:
            _on(plan, placed, "kitchen", int(rng.integers(1, 5)))
    plan.along_wall(thing("fridge", storage.fridge(rng)), front=0.6, corner=True)
    _table_group(plan, stock, ("table", "small_table", "small_table"), ("chair", "stool", "chair"), 6)
    if rng.random() < 0.35:
        bar = plan.along_wall(thing("bar", storage.desk_counter(rng, rng.uniform(1.2, 2.0))), gap=0.0)
        _bar_stools(plan, stock, bar)
    _storage(plan, ["bookshelf", "drawers", "wardrobe"], int(rng.integers(0, 2)))


def office(plan: Plan, stock: Stock) -> None:
    """Desks with chairs, shelves, a whiteboard, a table to meet at."""
    rng = plan.rng
    area = plan.shell.size[0] * plan.shell.size[1]
    for _ in range(int(rng.integers(1, 3 + int(area > 22)))):
        _desk(plan, stock, ("office_chair", "office_chair", "chair"))
    plan.on_wall(thing("whiteboard", storage.board(rng, "whiteboard")), 0.85, 1.0)
    _storage(plan, ["bookshelf", "sideboard", "bookshelf", "drawers"], int(rng.integers(1, 4)))
    if area > 18:
        _table_group(plan, stock, ("table", "small_table"), ("chair", "office_chair"), 6)
    for category in rng.permutation(["armchair", "chair", "sofa"])[: int(rng.integers(1, 3))]:
        _free_seat(plan, stock.pick(rng, str(category), most=1.9))


def waiting(plan: Plan, stock: Stock) -> None:
    """Seats in rows along the walls, low tables, a counter."""
    rng = plan.rng
    if rng.random() < 0.7:
        plan.along_wall(
            thing("reception", storage.desk_counter(rng, rng.uniform(1.3, 2.2))), gap=0.7, front=0.6
        )
    for _ in range(int(rng.integers(2, 4))):
        item = stock.pick(rng, "chair", "bench", "armchair", "sofa", most=1.9)
        first = plan.along_wall(item, gap=rng.uniform(0.04, 0.12))
        if first is None:
            continue
        plan.keep_front(first, LEG_ROOM)
        step = first.item.size[0] + rng.uniform(0.06, 0.25)
        for k in range(1, int(rng.integers(2, 5))):
            for side in (-1, 1):
                x, z = first.at(side * k * step, 0.0)
                more = plan.put(first.item, x, z, first.yaw)
                if more is not None:
                    plan.keep_front(more, LEG_ROOM)
    table = _free_seat(plan, stock.pick(rng, "low_table", "small_table"), front=0.0)
    if table is not None:
        _on(plan, table, "waiting", 3)
    _storage(plan, ["bookshelf", "sideboard"], int(rng.integers(0, 2)))


def cafe(plan: Plan, stock: Stock) -> None:
    """Small tables with chairs, a bar with high stools."""
    rng = plan.rng
    if rng.random() < 0.8:
        bar = plan.along_wall(
            thing("bar", storage.desk_counter(rng, rng.uniform(1.4, 2.6))), gap=rng.uniform(0.5, 0.7)
        )
        _bar_stools(plan, stock, bar)
    chair = stock.pick(rng, "chair")
    for _ in range(int(rng.integers(2, 3 + int(plan.shell.size[0] * plan.shell.size[1] / 7)))):
        seats = ("chair",) if rng.random() < 0.3 else ()
        _table_group(plan, stock, ("small_table", "small_table", "table"), seats, 4, seat=chair)
    if rng.random() < 0.5:
        _free_seat(plan, stock.pick(rng, "sofa", "bench", "armchair", most=2.1))
    _storage(plan, ["sideboard", "bookshelf"], int(rng.integers(0, 2)))


KINDS: dict[str, Callable[[Plan, Stock], None]] = {
    "living": living, "bedroom": bedroom, "dining": dining, "kitchen": kitchen, "office": office,
    "waiting": waiting, "cafe": cafe,
}  # fmt: skip


def finish(plan: Plan, kind: str) -> None:
    """Pictures, plants, lamps, and things on tables and cupboards."""
    rng = plan.rng
    for _ in range(int(rng.integers(0, 5))):
        plan.on_wall(thing("picture", storage.board(rng, "picture")), 1.1, 1.6)
    if rng.random() < 0.25:
        plan.on_wall(thing("whiteboard", storage.board(rng, "whiteboard")), 0.85, 1.0)
    tops = (
        "table",
        "small_table",
        "low_table",
        "desk",
        "sideboard",
        "drawers",
        "nightstand",
        "bar",
        "reception",
    )
    for placed in list(plan.placed):
        if placed.item.category in tops and placed.y == 0:
            _on(plan, placed, kind, int(rng.integers(0, 5)))
    for _ in range(int(rng.integers(1, 6))):
        build = clutter.ON_FLOOR[rng.integers(len(clutter.ON_FLOOR))]
        plan.along_wall(thing(build.__name__.strip("_"), build(rng)), gap=0.06, tries=8)


def _opposite(placed: Placed) -> list[int]:
    yaws = np.array([0.0, np.pi / 2, np.pi, -np.pi / 2])
    return [int(np.argmin(np.cos(yaws - placed.yaw)))]


def _low_table(plan: Plan, stock: Stock, sofa: Placed) -> None:
    rng = plan.rng
    item = stock.pick(rng, "low_table", most=max(1.0, 0.8 * sofa.item.size[0]))
    if item is None or rng.random() < 0.15:
        return
    reach = sofa.item.box[1][2] + rng.uniform(0.42, 0.65) + item.size[2] / 2
    x, z = sofa.at(rng.uniform(-0.25, 0.25), reach)
    plan.put(item, x, z, sofa.yaw + rng.choice([0.0, 0.0, rng.uniform(-0.2, 0.2)]))


def _beside_table(plan: Plan, stock: Stock, sofa: Placed) -> None:
    """Armchairs at the sides of the place in front of a sofa, facing it."""
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


def _free_seat(plan: Plan, item: Item | None, front: float = LEG_ROOM) -> Placed | None:
    """A seat at a wall, turned a little, or in a corner."""
    placed = plan.along_wall(item, gap=plan.rng.uniform(0.03, 0.25), front=front)
    return placed


def _rug(plan: Plan, centre: np.ndarray, yaw: float, scale: float = 1.0) -> None:
    rng = plan.rng
    if rng.random() < 0.35:
        return
    x, z = scale * rng.uniform(0.7, 1.4), scale * rng.uniform(0.5, 1.0)
    rug = thing("rug", [Part("floor", shapes.box((-x, 0.0, -z), (x, 0.004, z)))])
    room = np.array(plan.shell.size[:2]) / 2 - np.abs(turned(np.array([x, z]), yaw)) - 0.05
    if (room > 0).all():
        x, z = np.clip(centre, -room, room)
        plan.placed.append(Placed(rug, float(x), 0.0, float(z), yaw))


def _storage(plan: Plan, names: list[str], count: int) -> None:
    for name in plan.rng.permutation(names)[:count]:
        parts = getattr(storage, str(name))(plan.rng)
        plan.along_wall(thing(str(name), parts), front=0.35)


def _keep_beside(plan: Plan, bed: Placed, side: int) -> None:
    """Keeps a strip beside a bed free, if there is room for one."""
    from .floorplan import Rectangle

    low, high = bed.item.box
    x = (high[0] + 0.3) if side > 0 else (low[0] - 0.3)
    strip = Rectangle(
        bed.at(x, (low[2] + high[2]) / 2 + 0.25), np.array([0.27, (high[2] - low[2]) / 2 - 0.25]), bed.yaw
    )
    if plan.fits(strip, 0.0):
        plan.kept.append(strip)


def _desk(plan: Plan, stock: Stock, seats: tuple[str, ...]) -> None:
    """A desk with its front to the room and a chair pulled out from it."""
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
    _on(plan, desk, "office", int(rng.integers(1, 5)))


def _table_group(
    plan: Plan, stock: Stock, tables: tuple[str, ...], seats: tuple[str, ...], most: int, centre: bool = False,
    seat: Item | None = None,
) -> Placed | None:  # fmt: skip
    """A table with seats about it, most of them pulled out so far that one can sit down."""
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
                + rng.choice([rng.uniform(-0.15, 0.1), rng.uniform(0.3, 0.65)], p=[0.3, 0.7])
            )
            local = turned(np.array([at, pulled]), yaw)
            turn = rng.normal(0, 0.25 if pulled > out / 2 + 0.4 else 0.08)
            if plan.put(seat, *table.at(*local), table.yaw + yaw + np.pi + turn, air=0.01) is not None:
                most -= 1
    return table


def _bar_stools(plan: Plan, stock: Stock, bar: Placed | None) -> None:
    rng = plan.rng
    stool = stock.pick(rng, "bar_stool")
    if bar is None or stool is None:
        return
    for x in np.arange(-bar.item.size[0] / 2 + 0.35, bar.item.size[0] / 2 - 0.3, 0.65):
        if rng.random() < 0.75:
            place = bar.at(x, bar.item.box[1][2] + stool.box[1][2] + rng.uniform(0.1, 0.4))
            plan.put(stool, *place, bar.yaw + np.pi + rng.normal(0, 0.3), air=0.01)
    plan.keep_front(bar, 1.2)


def _on(plan: Plan, below: Placed, kind: str, count: int) -> None:
    """Things on a table or a cupboard."""
    rng = plan.rng
    low, high = below.item.box
    for _ in range(count):
        build = clutter.ON_TABLE[kind][rng.integers(len(clutter.ON_TABLE[kind]))]
        room = np.maximum((high - low)[[0, 2]] / 2 - 0.08, 0.02)
        place = (low + high)[[0, 2]] / 2 + rng.uniform(-1, 1, 2) * room
        turn = rng.normal(0, 0.3) if build in (clutter.monitor, clutter.laptop) else rng.uniform(0, 6.28)
        plan.on_top(below, thing(build.__name__, build(rng)), tuple(place), turn)
