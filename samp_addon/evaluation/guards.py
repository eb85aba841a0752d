"""Limits of what a take may show, and the sentences that say which it breaks."""

from __future__ import annotations

from collections.abc import Mapping

LIMITS = {
    "air_squat_s": (1.0, "The body squats in the air for {value:.1f} s, with nothing under the hips."),
    "unsupported_s": (0.25, "Nothing supports the body for {value:.1f} s."),
    "seated_speed_m_s": (0.6, "The seated body glides, at up to {value:.1f} m/s."),
    "hanging_feet_cm": (3.0, "The feet hang {value:.0f} cm over the floor while seated."),
}
"""Of the measures of support.py: the highest allowed value, and the warning beyond it."""

DEEP = 5.0
"""Centimetres. Deeper penetration is worth a warning."""


MEASURED = ("The body ", "Nothing supports ", "The seated body ", "The feet hang ", "The take ")
"""Beginnings of the sentences of `warnings`; those of other sources begin otherwise."""


def broken(numbers: Mapping) -> list[str]:
    """Return the names of the measures that are beyond their limits."""
    return [name for name, (limit, _) in LIMITS.items() if (numbers.get(name) or 0.0) > limit]


def warnings(numbers: Mapping) -> list[str]:
    """Return a sentence for each limit that a take's measures break; numbers: as of metrics.measure."""
    found = [LIMITS[name][1].format(value=numbers[name]) for name in broken(numbers)]
    if (numbers.get("penetration_max_cm") or 0.0) > DEEP:
        found.append(f"The body is {numbers['penetration_max_cm']:.0f} cm deep in the scene somewhere.")
    if numbers.get("success") is False:
        distance = numbers["position_error_cm"]
        found.append(
            f"The take ends {distance:.0f} cm from its goal."
            if distance > 20
            else "The take does not rest on its goal for a second."
        )
    return found
