"""Render episodes of a corpus: contact sheets and a short film with the picture, its depth and its classes.

python -m samp_blender.training.rooms.look --output cache/rooms --episodes 20 --to sheets
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ...samp_addon.body import human
from .classes import COLOURS
from .corpus import store, views
from .pictures import camera, paints, shading, tracer

COLUMNS = 9  # frames of an episode on its sheet
FILM_FPS, FILM_SECONDS = 10, 8
DEEPEST = 8.0  # depth (m) that is drawn black


class Stage:
    """An episode in its room, with its own paints and light."""

    def __init__(self, data: store.RoomData, episode: int, rng: np.random.Generator) -> None:
        self.motion = data.motion(episode)
        self.body = data.body(episode)
        self.room, self.rng = data.room, rng
        self.tracer = tracer.Tracer(data.room)
        self.above = tracer.Tracer(data.room, open_top=True)
        self.paints, self.light = paints.draw(data.room, rng), paints.light(data.room, rng)

    def view(self, seat: int) -> camera.Camera:
        """Return the camera in a corner of the room (0 to 3) that looks at the episode, or above it (4)."""
        width, depth, height = self.room.size
        middle = self.motion.root.mean(0)
        if seat == 4:
            far = 1.1 * max(width, depth) + height
            return camera.looking(np.array([0.01, far, 0.02]), np.zeros(3), np.radians(62))
        corner = np.array(
            [(-1, 1)[seat % 2] * (width / 2 - 0.2), 2.1, (-1, 1)[seat // 2] * (depth / 2 - 0.2)]
        )
        return camera.looking(corner, middle * [1, 0, 1] + [0, 0.8, 0], np.radians(84))

    def corners(self) -> list[int]:
        """Return the corners, ordered from the farthest from the episode's path to the nearest."""
        return sorted(
            range(4), key=lambda k: -np.linalg.norm(self.view(k).position - self.motion.root.mean(0))
        )

    def picture(
        self, seat: int, frame: int, size: tuple[int, int] = camera.SIZE, samples: int = 2
    ) -> shading.Picture:
        """Render a frame from one of the views."""
        skin = human.skin(self.body, self.motion.pose_slice(slice(frame, frame + 1)))[0]
        body = tracer.Body(skin, *views.faces())
        seen = self.above if seat == 4 else self.tracer
        return shading.picture(seen, self.view(seat), self.paints, self.light, body, self.rng, size, samples)


def maps(made: shading.Picture) -> tuple[np.ndarray, np.ndarray]:
    """Return depth and classes as pictures (H, W, 3), uint8."""
    near = np.clip(1 - made.depth / DEEPEST, 0, 1) * 255
    return np.repeat(near[..., None], 3, -1).astype(np.uint8), COLOURS[
        np.minimum(made.classes, len(COLOURS) - 1)
    ]


def sheet(stage: Stage) -> np.ndarray:
    """Return the contact sheet: a view with its depth and classes, one from the opposite side, one from above."""
    frames = np.linspace(0, len(stage.motion) - 1, COLUMNS).astype(int)
    first, *_, last = stage.corners()
    last = 3 - first
    rows: list[list[np.ndarray]] = [[], [], [], [], []]
    for frame in frames:
        front = stage.picture(first, frame)
        depth, classes = maps(front)
        others = [stage.picture(last, frame, samples=1).colour, stage.picture(4, frame, samples=1).colour]
        for row, tile in zip(rows, [front.colour, depth, classes, *others], strict=True):
            row.append(tile)
    return np.vstack([np.hstack(row) for row in rows])


def film(stages: list[Stage], path: Path) -> None:
    """Write a film with a few seconds of each episode: the picture, its depth, its classes."""
    from ...samp_addon.blender.render.movie import write_movie

    def frames():  # noqa: ANN202
        for stage in stages:
            first = stage.corners()[0]
            count = min(FILM_FPS * FILM_SECONDS, len(stage.motion) * FILM_FPS // 30)
            start = max((len(stage.motion) - 30 * FILM_SECONDS) // 2, 0)
            for k in range(count):
                made = stage.picture(first, start + k * 30 // FILM_FPS, samples=1)
                yield np.hstack([made.colour, *maps(made)])

    write_movie(path, frames(), FILM_FPS)


def main(arguments: list[str] | None = None) -> int:
    """Run the command; return its exit status."""
    from PIL import Image

    parser = argparse.ArgumentParser(prog="look", description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path("cache/rooms"), help="folder of the corpus")
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--film", type=int, default=6, help="episodes in the film")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--to", type=Path, help="folder of the sheets (default: CORPUS/sheets)")
    options = parser.parse_args(arguments)
    folder = options.to or options.output / "sheets"
    folder.mkdir(parents=True, exist_ok=True)
    corpus = store.Corpus(options.output)
    every = [(r["number"], e) for r in corpus.manifest["rooms"] for e in range(r["episodes"])]
    rng = np.random.default_rng(options.seed)
    chosen = [every[k] for k in rng.permutation(len(every))[: options.episodes]]
    stages = []
    for number, episode in chosen:
        stage = Stage(corpus.room(number), episode, rng)
        name = folder / f"room{number:04d}_episode{episode:02d}.png"
        Image.fromarray(sheet(stage)).save(name)
        print(name)
        stages = [*stages, stage][: options.film]
    if stages:
        film(stages, folder / "episodes.mp4")
        print(folder / "episodes.mp4")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
