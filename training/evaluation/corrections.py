"""Ablation of finishing: measures without each of its corrections in turn."""

from __future__ import annotations

from ...samp_addon.methods.samp.finishing import finish
from ...samp_addon.methods.samp.load_networks import MotionNetwork
from . import stages
from .stages import Stage

EVERY = "all"
COLUMNS = (
    ("success", "success"),
    ("position_error_cm", "PE, cm"),
    ("rotation_error_deg", "RE, deg"),
    ("penetration_2cm_percent", "deeper than 2 cm, %"),
    ("penetration_5cm_percent", "than 5 cm, %"),
    ("touches_back", "back at rest"),
    ("hanging_feet_cm", "feet over floor, cm"),
    ("stance_slide_cm_s", "stance slide, cm/s"),
    ("seated_speed_m_s", "pelvis seated, m/s"),
    ("jerk_m_s3", "jerk, m/s^3"),
)


def measure(jobs: stages.Jobs, network: MotionNetwork | None = None) -> dict[str, Stage]:
    """Generate the first attempt of each take with all corrections, and without each of them in turn."""
    found = {EVERY: stages.run(jobs, stages.FINISHED, network)}
    for name in finish.CORRECTIONS:
        found[f"without {name}"] = stages.run(jobs, stages.FINISHED, network, without=(name,))
    return found


def table(action: str, found: dict[str, Stage]) -> str:
    """Return a Markdown table with a row for each version of finishing."""
    lines = [f"{action}: corrections of finishing, first attempts", ""]
    lines.append("| corrections | " + " | ".join(name for _, name in COLUMNS) + " |")
    lines.append("|---" * (len(COLUMNS) + 1) + "|")
    for name, stage in found.items():
        cells = [stage.estimate(key) for key, _ in COLUMNS]
        lines.append(f"| {name} | " + " | ".join("-" if c is None else f"{c.mean:.2f}" for c in cells) + " |")
    return "\n".join(lines)
