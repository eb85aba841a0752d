"""Takes of several members, made as one batch where their methods can do so: step by step, all members at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ...methods.method import Method
from ...methods.scene_view import SceneView
from ...methods.step import Step
from ...methods.take import Take
from ...progress import Progress, SubProgress
from .. import attempts, steps
from ..attempts import Part

Row = Sequence[tuple[Step, SceneView]]
"""Steps of one member, and the scene as each sees it."""


def generate(
    rows: Mapping[int, Row], seeds: Mapping[int, int], methods: Mapping[str, Method], progress: Progress
) -> tuple[dict[int, Take], dict[int, str]]:
    """Return the take of each member, by its number, and why others have none.

    rows, seeds: by member.
    """
    done: dict[int, list[Take]] = {number: [] for number in rows}
    reasons: dict[int, str] = {}
    count = max((len(row) for row in rows.values()), default=0)
    for index in range(count):
        going = [number for number in rows if number not in reasons and index < len(rows[number])]
        parts = []
        for number in going:
            step, view = rows[number][index]
            before = done[number][-1] if done[number] else None
            if before is not None:
                view = replace(view, after={seeds[number]: before})
            parts.append(Part(methods[step.method], step, view, [seeds[number]]))
        made = attempts.generate_together(parts, SubProgress(progress, index / count, 1 / count))
        for number, (takes, failures) in zip(going, made, strict=True):
            if failures:
                where = f"step {index + 1}: " if len(rows[number]) > 1 else ""
                reasons[number] = where + failures[0].message
            done[number] += takes
    complete = {number: takes for number, takes in done.items() if number not in reasons and takes}
    return {
        number: takes[0] if len(takes) == 1 else steps.joined(takes) for number, takes in complete.items()
    }, reasons
