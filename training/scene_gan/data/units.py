"""Units and sizes of what the data set stores."""

from __future__ import annotations

ROOT_UNIT = 2e-4  # metres of a step of stored positions
HEIGHT_UNIT = 0.02  # metres of a step of stored heights
HEIGHT_CELL = 0.05  # metres
NOTHING = 255  # height of a cell without a surface
