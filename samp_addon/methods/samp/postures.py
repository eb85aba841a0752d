"""Postures of a rest (vocabulary.POSTURES): as the artist asks for them, or drawn as they occur in the training data.

Imports nothing but the standard library: the panel asks for a method's options at every redraw.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from random import Random

from ...errors import UsageError
from ...vocabulary import POSTURE_NAMES, POSTURES

EXCLUSIVE = (
    ("upright", "lean_back"),
    ("hands_on_lap", "hands_on_armrests", "hands_on_table"),
    ("on_back", "on_side", "half_sitting"),
)
"""Of each of these, a body can have one."""

NEEDS_PLACE = ("lean_back", "hands_on_armrests", "hands_on_table", "half_sitting")
"""Postures that need something beside the place where the body rests; see posture_places.py."""

WHERE_THERE_IS_PLACE = {"lean_back": 0.62}
"""Share of a posture among the rests that have a place for it. The network's shares are those of all rests, on seats
with and without a back; of 50 sits of the corpus on seats with one, 62 % touch it."""


def parse(text: str | None) -> tuple[str, ...]:
    """Return the postures of a text such as ``lean_back,hands_on_lap``. Raise UsageError for wrong ones.

    Postures of different actions may stand together: each step takes those of its own.
    """
    names = tuple(part.strip().lower().replace(" ", "_") for part in (text or "").split(",") if part.strip())
    for name in names:
        if name not in POSTURE_NAMES:
            raise UsageError(f"There is no posture '{name}'; choose of {', '.join(POSTURE_NAMES)}.")
    for group in EXCLUSIVE:
        both = [name for name in names if name in group]
        if len(set(both)) > 1:
            raise UsageError(f"A body cannot be {both[0]} and {both[1]} at once; name one of them.")
    return names


def of_action(names: Sequence[str], action: str) -> tuple[str, ...]:
    """Return those of the postures that belong to an action."""
    return tuple(name for name in names if name in POSTURES.get(action, ()))


def drawn(
    shares: Sequence[tuple[Collection[str], float]], action: str, places: Collection[str], seed: int,
    wanted: Sequence[str] = (),
) -> tuple[str, ...]:  # fmt: skip
    """Return a combination of postures for an action, drawn by its share among those that have a place.

    shares: combinations and how common each is. places: those of NEEDS_PLACE for which there is one. wanted: postures
    that the combination contains, with a place or without; alone, where no combination has them all.
    """
    missing = set(NEEDS_PLACE) - set(places) - set(wanted)
    fitting = [
        (names, share)
        for names, share in shares
        if share > 0
        and names
        and set(wanted) <= set(names) <= set(POSTURES.get(action, ()))
        and not missing & set(names)
    ]
    if not fitting:
        return tuple(wanted)
    for name, share in WHERE_THERE_IS_PLACE.items():
        fitting = _with_share(fitting, name, share) if name in places else fitting
    # Another stream than the rollout's, which has the same seed.
    choice = Random(f"posture {seed}").choices(
        [names for names, _ in fitting], [share for _, share in fitting]
    )[0]
    return tuple(name for name in POSTURE_NAMES if name in choice)


def _with_share(
    shares: list[tuple[Collection[str], float]], name: str, wanted: float
) -> list[tuple[Collection[str], float]]:
    """Return the shares, scaled so that those of the combinations with a posture sum to ``wanted``.

    They are unchanged if all or none of the combinations have the posture.
    """
    total = sum(share for _, share in shares)
    having = sum(share for names, share in shares if name in names)
    if not 0 < having < total:
        return shares
    of = {True: wanted / having, False: (1 - wanted) / (total - having)}
    return [(names, share * of[name in names]) for names, share in shares]


def numbers(names: Collection[str]) -> list[float]:
    """Return MotionNet's numbers (9,) for postures."""
    return [float(name in names) for name in POSTURE_NAMES]
