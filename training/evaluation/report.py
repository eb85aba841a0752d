"""Markdown tables of the evaluation: one for each action, and a comparison of networks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...samp_addon.evaluation import diversity
from ...samp_addon.motion import Motion
from . import reference, tables
from .takes import Results

POSTURE = (
    ("knee_deg", "knee, deg"), ("straight_deg", "straightest knee, deg"), ("elbow_deg", "elbow, deg"),
    ("lower_trunk_deg", "lower trunk, deg"), ("upper_trunk_deg", "upper trunk, deg"), ("neck_deg", "neck, deg"),
    ("step_width_m", "width of the stance, m"),
)  # fmt: skip
MEANS = (
    ("position_error_cm", "PE, cm"),
    ("rotation_error_deg", "RE, deg"),
    ("execution_time_s", "execution time, s"),
    ("penetration_2cm_percent", "frames deeper than 2 cm, %"),
    ("penetration_5cm_percent", "frames deeper than 5 cm, %"),
    ("penetration_max_cm", "deepest, cm"),
    ("non_collision", "non-collision"),
    ("contact", "contact"),
    ("foot_slide_cm_s", "foot slide, cm/s"),
    ("stance_slide_cm_s", "stance slide, cm/s"),
    ("glide_s", "gliding on both feet, s"),
    ("stance_share", "share of time in stance"),
    ("jerk_m_s3", "jerk, m/s^3"),
    ("air_squat_s", "squat in the air, s"),
    ("unsupported_s", "without support, s"),
    ("seated_speed_m_s", "pelvis while seated, m/s"),
    ("hanging_feet_cm", "feet over the floor in the hold, cm"),
    *(
        (f"{phase}_{key}", f"{phase}: {name}")
        for phase in ("walk", "idle", "seated")
        for key, name in POSTURE
    ),
)
COMPARED = ("position_error_cm", "rotation_error_deg", "execution_time_s", "penetration_5cm_percent",
            "foot_slide_cm_s", "stance_slide_cm_s")  # fmt: skip


def table(
    action: str, results: Results, real: Sequence[Motion], pace: tuple[float, float] | None = None
) -> str:
    """Return the measures of an action. real: its held-out motion. pace: see reference.real_pace."""
    asked = results.asked
    lines = [f"{action}: {len(results.takes)} takes of {asked} asked for"]
    if not results.takes:
        return lines[0]
    won = _won(results)
    low, high = tables.share(won, asked)
    first = sum(numbers["attempts"] == 1 and bool(numbers["success"]) for numbers in results.numbers)
    lines += ["", tables.HEADER]
    lines.append(tables.row(action, "success", "success", f"{won} of {asked} ({low:.0%} to {high:.0%})"))
    lines.append(tables.row(action, "first", "success at the first attempt", f"{first} of {asked}"))
    own = reference.measures(real, action)
    for key, name in MEANS:
        if (found := results.estimate(key)) is not None:
            lines.append(tables.row(action, key, name, str(found), own.get(key)))
    if pace is not None and (ratios := reference.execution_ratios(results, pace)):
        ratio = str(tables.Estimate.of(ratios))
        lines.append(tables.row(action, "execution_ratio", "execution time over real", ratio))
    if results.alike:
        aligned = tables.Estimate.of([diversity.diversity_in_time(motions) for motions in results.alike])
        lines.append(tables.row(action, "APD_in_time", "APD between takes, frame by frame", str(aligned)))
    if (apd := _apd(action, results)) is not None:
        lines.append(tables.row(action, "APD", "APD as in the paper, pooled", str(apd), own.get("APD")))
    if real:
        lines.append(tables.row(action, "FD", "FD", f"{_distance(results, real):.2f}"))
    return "\n".join(lines)


def comparison(action: str, versions: Mapping[str, Results], real: Sequence[Motion]) -> str:
    """Return a comparison of networks (tables 2 to 5), with a row for each, by name."""
    names = dict(MEANS)
    columns = ["success", *(names[key] for key in COMPARED), "APD", "FD"]
    lines = [f"| {action} | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for name, results in versions.items():
        cells = [f"{_won(results)} of {results.asked}"]
        for key in COMPARED:
            found = results.estimate(key)
            cells.append("-" if found is None else str(found))
        apd = _apd(action, results)
        cells.append("-" if apd is None else str(apd))
        cells.append(f"{_distance(results, real):.2f}" if real and results.takes else "-")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _won(results: Results) -> int:
    return sum(bool(numbers["success"]) for numbers in results.numbers)


def _apd(action: str, results: Results) -> tables.Estimate | None:
    """Return the APD over takes of the same job, pooled over time as in section 5.2, to compare with the paper."""
    if not results.alike:
        return None
    return tables.Estimate.of(
        [diversity.diversity([reference.spell(m, action) for m in motions]) for motions in results.alike]
    )


def _distance(results: Results, real: Sequence[Motion]) -> float:
    return diversity.motion_distance([take.motion for take in results.takes], real)
