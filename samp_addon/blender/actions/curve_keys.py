"""The keys of an f-curve with all their properties, read and written in bulk."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

# Properties of a key with size and type. Handle types come before handles, because setting a type moves the handle.
_PROPERTIES = {
    **dict.fromkeys(
        ("interpolation", "easing", "handle_left_type", "handle_right_type", "type"), (1, np.int32)
    ),
    **dict.fromkeys(("amplitude", "period", "back"), (1, np.float32)),
    **dict.fromkeys(("co", "handle_left", "handle_right"), (2, np.float32)),
}


def choice(name: str, identifier: str) -> int:
    """Return the integer value of an enum item, for foreach_get and foreach_set."""
    return bpy.types.Keyframe.bl_rna.properties[name].enum_items[identifier].value


@dataclass(frozen=True)
class CurveKeys:
    """Properties of keys of a curve: name -> (n, 1), or (n, 2) for points."""

    values: dict[str, np.ndarray]

    @classmethod
    def of(cls, curve: bpy.types.FCurve) -> CurveKeys:
        """Read the keys of a curve."""
        points, values = curve.keyframe_points, {}
        for name, (shape, kind) in _PROPERTIES.items():
            flat = np.empty(len(points) * shape, dtype=kind)
            points.foreach_get(name, flat)
            values[name] = flat.reshape(len(points), shape)
        return cls(values)

    @classmethod
    def linear(cls, times: np.ndarray, heights: np.ndarray) -> CurveKeys:
        """Make keys at frames (n,) with linear interpolation."""
        count = len(times)
        values = {name: np.zeros((count, shape), dtype=kind) for name, (shape, kind) in _PROPERTIES.items()}
        values["co"][:] = values["handle_left"][:] = values["handle_right"][:] = np.stack([times, heights], 1)
        values["interpolation"][:] = choice("interpolation", "LINEAR")
        for side in ("handle_left_type", "handle_right_type"):
            values[side][:] = choice(side, "AUTO_CLAMPED")
        for name, default in (("amplitude", 0.8), ("period", 4.1), ("back", 1.70158)):
            values[name][:] = default
        return cls(values)

    @classmethod
    def cubic(cls, times: np.ndarray, heights: np.ndarray, slopes: np.ndarray) -> CurveKeys:
        """Make keys at frames (n,) with cubic pieces between them; slopes: (n - 1, 2) at both ends of each piece."""
        keys = cls.linear(times, heights)
        keys.values["interpolation"][:] = choice("interpolation", "BEZIER")
        for side in ("handle_left_type", "handle_right_type"):
            keys.values[side][:] = choice(side, "FREE")
        # With handles at a third of the interval, time runs evenly along the Bezier curve.
        third = np.diff(times) / 3
        for side, rows, sign, end in (
            ("handle_right", slice(None, -1), 1, 0),
            ("handle_left", slice(1, None), -1, 1),
        ):
            keys.values[side][rows] += sign * np.stack([third, third * slopes[:, end]], -1)
        return keys

    @classmethod
    def joined(cls, parts: list[CurveKeys]) -> CurveKeys:
        """Concatenate keys in the given order."""
        return cls({name: np.concatenate([part.values[name] for part in parts]) for name in _PROPERTIES})

    @property
    def at(self) -> np.ndarray:
        """Frames (n,) of the keys."""
        return self.values["co"][:, 0]

    def where(self, flags: np.ndarray) -> CurveKeys:
        """Return the keys whose flag (n,) is set."""
        return CurveKeys({name: value[flags] for name, value in self.values.items()})

    def frozen(self) -> CurveKeys:
        """Return the keys with handles that stay when neighbouring keys change."""
        values = dict(self.values)
        for side in ("handle_left_type", "handle_right_type"):
            straight = np.isin(values[side], [choice(side, kind) for kind in ("AUTO", "AUTO_CLAMPED")])
            free = values[side] == choice(side, "VECTOR")
            values[side] = np.where(straight, choice(side, "ALIGNED"), values[side])
            values[side][free] = choice(side, "FREE")
        return CurveKeys(values)

    def replace_in(self, curve: bpy.types.FCurve) -> None:
        """Replace all keys of a curve by these."""
        points = curve.keyframe_points
        points.clear()
        points.add(len(self.at))
        for name, value in self.values.items():
            points.foreach_set(name, value.ravel())
        curve.update()
