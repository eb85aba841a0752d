"""The seven kinds of rooms: their furniture and its arrangement."""

from __future__ import annotations

from collections.abc import Callable

from . import clutter
from . import storage as cupboards
from .floorplan import Placed, Plan
from .groups import (
    LEG_ROOM,
    bar_stools,
    beside_table,
    desk,
    free_seat,
    item_of,
    keep_beside,
    low_table,
    opposite,
    put_on,
    rug,
    storage,
    table_group,
)
from .stock import Stock


def living(plan: Plan, stock: Stock) -> None:
    """Furnish a living room: sofas and armchairs around a low table, a screen opposite, shelves."""
    rng = plan.rng
    sofa = plan.along_wall(
        stock.pick(rng, "sofa", "sofa", "l_sofa", most=0.8 * max(plan.shell.size[:2])),
        gap=rng.uniform(0.02, 0.12),
    )
    if sofa is None:
        sofa = plan.along_wall(stock.pick(rng, "sofa", "armchair", most=1.7), gap=0.03)
    if sofa is not None:
        low_table(plan, stock, sofa)
        beside_table(plan, stock, sofa)
        plan.keep_front(sofa, LEG_ROOM)
        rug(plan, sofa.at(0.0, sofa.item.box[1][2] + 0.6), sofa.yaw)
        screen = item_of("screen", cupboards.board(rng, "screen"))
        low = plan.along_wall(item_of("sideboard", cupboards.sideboard(rng)), opposite(sofa), front=0.4)
        if low is not None:
            y = low.item.box[1][1]
            base = Placed(screen, *low.at(0.0, 0.1)[:1], y + 0.04, low.at(0.0, 0.1)[1], low.yaw)
            plan.placed.append(base)
    for category in rng.permutation(["armchair", "pouf", "chair", "sofa"])[: int(rng.integers(1, 4))]:
        free_seat(plan, stock.pick(rng, str(category), most=2.2))
    storage(plan, ["bookshelf", "bookshelf", "sideboard", "drawers"], int(rng.integers(1, 4)))
    if plan.shell.size[0] * plan.shell.size[1] > 22 and rng.random() < 0.6:
        table_group(plan, stock, ("table", "small_table"), ("chair",), 4)


def bedroom(plan: Plan, stock: Stock) -> None:
    """Furnish a bedroom: one bed or two, nightstands, wardrobes, a chair or a desk."""
    rng = plan.rng
    for number in range(2 if rng.random() < 0.25 else 1):
        bed = plan.along_wall(stock.pick(rng, "bed"), gap=0.03, air=0.35 if number == 0 else 0.1)
        if bed is None:
            continue
        low, high = bed.item.box
        for side in (-1, 1):
            stand = item_of("nightstand", cupboards.nightstand(rng))
            x = high[0] + stand.size[0] / 2 + 0.05 if side > 0 else low[0] - stand.size[0] / 2 - 0.05
            if rng.random() < 0.8:
                plan.put(stand, *bed.at(x, low[2] + 0.03), bed.yaw, air=0.0)
        for side in (-1, 1):
            keep_beside(plan, bed, side)
        rug(plan, bed.at(0.0, high[2]), bed.yaw)
    storage(plan, ["wardrobe", "drawers", "wardrobe"], int(rng.integers(1, 3)))
    if rng.random() < 0.6:
        desk(plan, stock, ("chair", "office_chair"))
    for category in rng.permutation(["armchair", "bench", "pouf", "chair", "lounger"])[
        : int(rng.integers(1, 3))
    ]:
        free_seat(plan, stock.pick(rng, str(category), most=2.1))


def dining(plan: Plan, stock: Stock) -> None:
    """Furnish a dining room: a table with chairs in the middle, sideboards along the walls."""
    rng = plan.rng
    table = table_group(
        plan, stock, ("table", "table", "small_table", "desk"), ("chair", "chair", "bench"), 8, centre=True
    )
    if table is not None and rng.random() < 0.6:
        rug(plan, table.at(0, 0), table.yaw, 1.3)
    storage(plan, ["sideboard", "drawers", "bookshelf", "sideboard"], int(rng.integers(1, 4)))
    for category in rng.permutation(["armchair", "sofa", "bench"])[: int(rng.integers(0, 3))]:
        free_seat(plan, stock.pick(rng, str(category), most=2.0))


def kitchen(plan: Plan, stock: Stock) -> None:
    """Furnish a kitchen: a counter along one wall or two, a fridge, a table with chairs or stools."""
    rng = plan.rng
    longest = max(plan.shell.size[:2])
    for number in range(1 if rng.random() < 0.5 else 2):
        width = min(rng.uniform(1.6, 3.4) if number == 0 else rng.uniform(1.0, 2.0), longest - 0.5)
        run = item_of("counter", cupboards.counter(rng, width, rng.random() < 0.7))
        placed = plan.along_wall(run, gap=0.0, front=0.7, corner=number == 0 and rng.random() < 0.7)
        if placed is not None:
            put_on(plan, placed, "kitchen", int(rng.integers(1, 5)))
    plan.along_wall(item_of("fridge", cupboards.fridge(rng)), front=0.6, corner=True)
    table_group(plan, stock, ("table", "small_table", "small_table"), ("chair", "stool", "chair"), 6)
    if rng.random() < 0.35:
        bar = plan.along_wall(item_of("bar", cupboards.desk_counter(rng, rng.uniform(1.2, 2.0))), gap=0.0)
        bar_stools(plan, stock, bar)
    storage(plan, ["bookshelf", "drawers", "wardrobe"], int(rng.integers(0, 2)))


def office(plan: Plan, stock: Stock) -> None:
    """Furnish an office: desks with chairs, shelves, a whiteboard, a meeting table."""
    rng = plan.rng
    area = plan.shell.size[0] * plan.shell.size[1]
    for _ in range(int(rng.integers(1, 3 + int(area > 22)))):
        desk(plan, stock, ("office_chair", "office_chair", "chair"))
    plan.on_wall(item_of("whiteboard", cupboards.board(rng, "whiteboard")), 0.85, 1.0)
    storage(plan, ["bookshelf", "sideboard", "bookshelf", "drawers"], int(rng.integers(1, 4)))
    if area > 18:
        table_group(plan, stock, ("table", "small_table"), ("chair", "office_chair"), 6)
    for category in rng.permutation(["armchair", "chair", "sofa"])[: int(rng.integers(1, 3))]:
        free_seat(plan, stock.pick(rng, str(category), most=1.9))


def waiting(plan: Plan, stock: Stock) -> None:
    """Furnish a waiting room: rows of seats along the walls, low tables, a counter."""
    rng = plan.rng
    if rng.random() < 0.7:
        plan.along_wall(
            item_of("reception", cupboards.desk_counter(rng, rng.uniform(1.3, 2.2))), gap=0.7, front=0.6
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
    table = free_seat(plan, stock.pick(rng, "low_table", "small_table"), front=0.0)
    if table is not None:
        put_on(plan, table, "waiting", 3)
    storage(plan, ["bookshelf", "sideboard"], int(rng.integers(0, 2)))


def cafe(plan: Plan, stock: Stock) -> None:
    """Furnish a cafe: small tables with chairs, a bar with high stools."""
    rng = plan.rng
    if rng.random() < 0.8:
        bar = plan.along_wall(
            item_of("bar", cupboards.desk_counter(rng, rng.uniform(1.4, 2.6))), gap=rng.uniform(0.5, 0.7)
        )
        bar_stools(plan, stock, bar)
    chair = stock.pick(rng, "chair")
    for _ in range(int(rng.integers(2, 3 + int(plan.shell.size[0] * plan.shell.size[1] / 7)))):
        seats = ("chair",) if rng.random() < 0.3 else ()
        table_group(plan, stock, ("small_table", "small_table", "table"), seats, 4, seat=chair)
    if rng.random() < 0.5:
        free_seat(plan, stock.pick(rng, "sofa", "bench", "armchair", most=2.1))
    storage(plan, ["sideboard", "bookshelf"], int(rng.integers(0, 2)))


KINDS: dict[str, Callable[[Plan, Stock], None]] = {
    "living": living, "bedroom": bedroom, "dining": dining, "kitchen": kitchen, "office": office,
    "waiting": waiting, "cafe": cafe,
}  # fmt: skip


def finish(plan: Plan, kind: str) -> None:
    """Add pictures, plants, lamps, and objects on tables and cupboards."""
    rng = plan.rng
    for _ in range(int(rng.integers(0, 5))):
        plan.on_wall(item_of("picture", cupboards.board(rng, "picture")), 1.1, 1.6)
    if rng.random() < 0.25:
        plan.on_wall(item_of("whiteboard", cupboards.board(rng, "whiteboard")), 0.85, 1.0)
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
            put_on(plan, placed, kind, int(rng.integers(0, 5)))
    for _ in range(int(rng.integers(1, 6))):
        build = clutter.ON_FLOOR[rng.integers(len(clutter.ON_FLOOR))]
        plan.along_wall(item_of(build.__name__.strip("_"), build(rng)), gap=0.06, tries=8)
