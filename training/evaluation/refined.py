"""Measures of the evaluation's takes before and after refinement."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from ...samp_addon.evaluation import metrics
from ...samp_addon.evaluation.obstacles import shared
from ...samp_addon.methods.take import Take
from ...samp_addon.refine.refinement import Surroundings, refine
from ...samp_addon.scene.geometry import SceneGeometry
from .tables import Estimate

WANTED = {
    "non_collision": ">= 0.9995", "contact": ">= 0.995", "penetration_2cm_percent": "<= 1",
    "stance_slide_cm_s": "<= 1", "foot_slide_cm_s": "<= 0.8 x real", "position_error_cm": "no worse",
    "rotation_error_deg": "no worse", "jerk_m_s3": "<= input",
}  # fmt: skip
NAMES = {
    "non_collision": "non-collision", "contact": "contact", "penetration_2cm_percent": "frames deeper than 2 cm, %",
    "penetration_5cm_percent": "frames deeper than 5 cm, %", "penetration_max_cm": "deepest, cm",
    "stance_slide_cm_s": "stance slide, cm/s", "foot_slide_cm_s": "foot slide, cm/s", "position_error_cm": "PE, cm",
    "rotation_error_deg": "RE, deg", "jerk_m_s3": "jerk, m/s^3",
}  # fmt: skip


@dataclass(frozen=True)
class Mended:
    """Measures before and after, seconds of computation per second of motion, and remaining depth, metres."""

    before: dict
    after: dict
    pace: float
    unsolved: float


def mend(take: Take, scene: SceneGeometry) -> Mended:
    """Refine a take of the evaluation, with rigid objects; return its measures."""
    floor = take.floor
    begun = time.perf_counter()
    made = refine(
        take.motion, Surroundings(scene.triangles, np.zeros(len(scene)), floor), take.goal, measured=False
    )
    seconds = time.perf_counter() - begun
    obstacles = shared(scene.triangles)
    numbers = [metrics.measure(m, take.goal, obstacles, floor) for m in (take.motion, made.motion)]
    return Mended(*numbers, seconds / max(take.motion.seconds, 1e-6), made.unsolved)


def table(action: str, mended: list[Mended]) -> str:
    """Return a Markdown table of each measure before and after."""
    lines = [
        f"{action}, refined: {len(mended)} takes",
        "",
        "| measure | before | after | wanted |",
        "|---|---|---|---|",
    ]
    for key, name in NAMES.items():
        cells = []
        for numbers in ([m.before for m in mended], [m.after for m in mended]):
            values = [n[key] for n in numbers if n.get(key) is not None]
            cells.append(_cell(key, values))
        lines.append(f"| {name} | {cells[0]} | {cells[1]} | {WANTED.get(key, '')} |")
    lines.append(f"| seconds for a second of motion | | {Estimate.of([m.pace for m in mended])} | <= 1.0 |")
    unsolved = sum(m.unsolved > 0.02 for m in mended)
    lines.append(f"| reported as unsolved | | {unsolved} of {len(mended)} | |")
    return "\n".join(lines)


def _cell(key: str, values: list[float]) -> str:
    if not values:
        return "-"
    mean = Estimate.of(values)
    return f"{mean.mean:.4f} ± {mean.half:.4f}" if key in ("non_collision", "contact") else str(mean)
