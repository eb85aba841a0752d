"""Units and sizes of the stored data set."""

from __future__ import annotations

ROOT_UNIT = 2e-4  # metres per unit of stored positions
HEIGHT_UNIT = 0.02  # metres per unit of stored heights
HEIGHT_CELL = 0.05  # size of a cell, metres
NOTHING = 255  # height of a cell without a surface
IDLE = 1  # label of standing frames, as in rooms/episodes/bank.py
