"""Shade one picture: direct light with shadows, one bounce of ambient light, and its depth, normals and classes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import paints as colours
from .camera import SIZE, Camera
from .paints import Light, Paint
from .tracer import NUDGE, Body, Hits, Tracer

AROUND = 6  # rays per pixel for ambient light
SOFT = 0.08  # radius of a lamp, metres
SUN_BLUR = 0.008  # angular sigma of the sun, radians
FAR_LAMP = 1.0  # distance (m) at which a lamp's irradiance is its colour


@dataclass
class Picture:
    """A picture with its maps.

    colour: (H, W, 3) uint8. depth: (H, W) metres along the camera's axis. normal: (H, W, 3) in camera coordinates (x
    right, y down, z forward). classes: (H, W).
    """

    colour: np.ndarray
    depth: np.ndarray
    normal: np.ndarray
    classes: np.ndarray


def picture(
    tracer: Tracer, camera: Camera, paints: dict[int, Paint], light: Light, body: Body | None,
    rng: np.random.Generator, size: tuple[int, int] = SIZE, samples: int = 2,
) -> Picture:  # fmt: skip
    """Render a room with a body. samples: jittered rays per pixel for the colours."""
    width, height = size
    straight = camera.rays(size).reshape(-1, 3)
    eye = np.broadcast_to(camera.position, straight.shape)
    seen = tracer.trace(eye, straight, body)
    total = np.zeros((width * height, 3))
    bounced = None
    for k in range(samples):
        jitter = rng.random((height, width, 2))
        ways = camera.rays(size, jitter).reshape(-1, 3)
        hits = tracer.trace(eye, ways, body)
        base = colours.albedo(paints, hits.paints, hits.point, hits.normal)
        if k == 0:
            bounced = _smoothed(_coarse_around(tracer, seen, paints, light, body, rng, size), seen, size)
        lit = _direct(tracer, hits, light, body, rng) + bounced
        shine = np.array([getattr(paints.get(int(p)), "shine", 0.0) for p in np.unique(hits.paints)])
        gloss = shine[np.searchsorted(np.unique(hits.paints), hits.paints)]
        value = base * lit + _glints(hits, ways, light, gloss)
        outside = (hits.classes == 4) & (base.min(-1) > 0.85) | ~np.isfinite(hits.distance)
        total += np.where(outside[:, None], light.sky * (0.6 + 0.8 * (ways[:, 1:2] * 0.5 + 0.5)), value)
    colour = _developed(total / samples, light, rng).reshape(height, width, 3)
    forward = -(straight @ camera.axes[2])
    depth = np.where(np.isfinite(seen.distance), seen.distance * forward, 0.0)
    normal = seen.normal @ camera.axes.T * np.array([1.0, -1.0, -1.0])
    return Picture(
        colour,
        depth.reshape(height, width),
        normal.reshape(height, width, 3),
        seen.classes.reshape(height, width),
    )


def _direct(
    tracer: Tracer, hits: Hits, light: Light, body: Body | None, rng: np.random.Generator
) -> np.ndarray:
    """Return the light (N, 3) from the sun and the lamps, with soft shadows."""
    start = hits.point + hits.normal * NUDGE
    out = np.zeros((len(start), 3))
    if light.sun_colour.any():
        way = light.sun + rng.normal(0, SUN_BLUR, start.shape)
        way /= np.linalg.norm(way, axis=-1, keepdims=True)
        facing = np.maximum((hits.normal * way).sum(-1), 0)
        free = ~tracer.blocked(start, way, 60.0, body)
        out += (facing * free)[:, None] * light.sun_colour
    for place, colour in zip(light.lamps, light.lamp_colours, strict=True):
        away = place + rng.normal(0, SOFT, start.shape) - start
        distance = np.linalg.norm(away, axis=-1)
        way = away / np.maximum(distance, 1e-6)[:, None]
        facing = np.maximum((hits.normal * way).sum(-1), 0)
        free = ~tracer.blocked(start, way, distance - 0.05, body)
        out += (facing * free * (FAR_LAMP / np.maximum(distance, 0.4)) ** 2)[:, None] * colour
    return out


def _coarse_around(
    tracer: Tracer, seen: Hits, paints: dict[int, Paint], light: Light, body: Body | None,
    rng: np.random.Generator, size: tuple[int, int],
) -> np.ndarray:  # fmt: skip
    """Return the ambient light (N, 3), computed for one pixel in four and repeated."""
    width, height = size
    rows = np.arange(width * height).reshape(height, width)[::2, ::2]
    few = Hits(*(getattr(seen, name)[rows.ravel()] for name in Hits.__dataclass_fields__))
    found = _around(tracer, few, paints, light, body, rng).reshape(*rows.shape, 3)
    return np.repeat(np.repeat(found, 2, 0)[:height], 2, 1)[:, :width].reshape(-1, 3)


def _around(
    tracer: Tracer,
    seen: Hits,
    paints: dict[int, Paint],
    light: Light,
    body: Body | None,
    rng: np.random.Generator,
) -> np.ndarray:
    """Return the ambient light (N, 3) along random rays: the sky through windows, or surfaces in the fill light."""
    start = seen.point + seen.normal * NUDGE
    out = np.zeros((len(start), 3))
    mean = {number: paint.colours.mean(0) for number, paint in paints.items()}
    numbers = np.array(sorted(mean))
    table = np.stack([mean[n] for n in numbers])
    for _ in range(AROUND):
        way = seen.normal + _sphere(len(start), rng)
        way /= np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-6)
        found = tracer.trace(start, way, body)
        row = np.clip(np.searchsorted(numbers, found.paints), 0, len(numbers) - 1)
        colour = table[row]
        sky = (found.classes == 4) & (colour.min(-1) > 0.85) | ~np.isfinite(found.distance)
        # Darken contributions of near surfaces, as ambient occlusion does.
        near = np.clip(found.distance / 0.7, 0.15, 1.0)[:, None]
        out += np.where(sky[:, None], light.sky, light.fill * near * (0.35 + 0.9 * colour))
    return out / AROUND


def _sphere(count: int, rng: np.random.Generator) -> np.ndarray:
    way = rng.normal(size=(count, 3))
    return way / np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-9)


def _smoothed(
    values: np.ndarray, seen: Hits, size: tuple[int, int], rounds: tuple[int, ...] = (1, 2)
) -> np.ndarray:
    """Return values (N, 3) denoised by averaging neighbours in the same plane, with growing strides."""
    width, height = size
    grid = values.reshape(height, width, 3)
    normal = seen.normal.reshape(height, width, 3)
    point = seen.point.reshape(height, width, 3)
    for step in rounds:
        total, weight = grid.copy(), np.ones((height, width, 1))
        for dy in (-step, 0, step):
            for dx in (-step, 0, step):
                if not dx and not dy:
                    continue
                shift = lambda a, dy=dy, dx=dx: np.roll(a, (dy, dx), (0, 1))
                alike = (normal * shift(normal)).sum(-1) > 0.9
                alike &= np.abs(((shift(point) - point) * normal).sum(-1)) < 0.03
                share = alike[..., None].astype(float)
                total += shift(grid) * share
                weight += share
        grid = total / weight
    return grid.reshape(-1, 3)


def _glints(hits: Hits, ways: np.ndarray, light: Light, gloss: np.ndarray) -> np.ndarray:
    """Return the highlights (N, 3) of the lamps."""
    out = np.zeros((len(ways), 3))
    mirrored = ways - 2 * (ways * hits.normal).sum(-1, keepdims=True) * hits.normal
    for place, colour in zip(light.lamps, light.lamp_colours, strict=True):
        away = place - hits.point
        away /= np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), 1e-6)
        out += (gloss * np.maximum((mirrored * away).sum(-1), 0) ** 30 * 0.3)[:, None] * colour
    return out


def _developed(value: np.ndarray, light: Light, rng: np.random.Generator) -> np.ndarray:
    """Convert linear light (N, 3) to uint8: automatic exposure, soft shoulder, gamma, slight noise."""
    middle = np.exp(np.log(value.mean(-1) + 1e-4).mean())
    exposed = value * 0.2 * light.exposure / middle
    mapped = exposed / (1 + 0.35 * exposed)
    mapped = np.clip(mapped, 0, 1) ** (1 / 2.2)
    return np.clip(mapped * 255 + rng.normal(0, 2.0, mapped.shape), 0, 255).astype(np.uint8)
