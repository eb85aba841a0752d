"""Losses over time: a log with a line of JSON for each report, and a plot."""

from __future__ import annotations

import json
from pathlib import Path

from PIL import Image, ImageDraw

PANEL = (420, 150)
COLUMNS = 3


def note(path: Path, step: int, seconds: float, values: dict[str, float]) -> None:
    """Append a line to a log."""
    rounded = {name: round(value, 6) for name, value in values.items()}
    with path.open("a") as file:
        file.write(json.dumps({"step": step, "seconds": round(seconds, 1)} | rounded) + "\n")


def read(path: Path) -> list[dict[str, float]]:
    """Return the lines of a log, without a truncated last line."""
    found = []
    for line in path.read_text().splitlines() if path.exists() else ():
        try:
            found.append(json.loads(line))
        except ValueError:
            continue
    return found


def draw(rows: list[dict[str, float]], path: Path) -> None:
    """Draw one panel for each value of a log over its steps."""
    names = [
        name for name in dict.fromkeys(k for row in rows for k in row) if name not in ("step", "seconds")
    ]
    if len(rows) < 2 or not names:
        return
    height = PANEL[1] * -(-len(names) // COLUMNS)
    made = Image.new("RGB", (PANEL[0] * COLUMNS, height), "white")
    pen = ImageDraw.Draw(made)
    last = max(rows[-1]["step"], 1)
    for number, name in enumerate(names):
        left, top = PANEL[0] * (number % COLUMNS), PANEL[1] * (number // COLUMNS)
        points = [(row["step"], row[name]) for row in rows if name in row]
        low, high = min(v for _, v in points), max(v for _, v in points)
        span = max(high - low, 1e-9)
        line = [
            (left + 8 + (PANEL[0] - 16) * s / last, top + PANEL[1] - 12 - (PANEL[1] - 36) * (v - low) / span)
            for s, v in points
        ]
        pen.rectangle([left, top, left + PANEL[0] - 1, top + PANEL[1] - 1], outline=(200, 200, 200))
        pen.text(
            (left + 8, top + 4), f"{name}  {low:.3g} to {high:.3g}, now {points[-1][1]:.3g}", fill="black"
        )
        if len(line) > 1:
            pen.line(line, fill=(40, 90, 200), width=2)
    made.save(path)
