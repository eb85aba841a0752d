"""Render motion files on an empty stage as a contact sheet and a film.

python -m samp_blender.training.look MOTION.npz OUT.png [--follow] [--movie OUT.mp4] [--object CHAIR.npy]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..samp_addon.motion import Motion


def load_motion(path: str | Path) -> Motion:
    """Read a motion from an .npz with the keys of training clips (root_pos, ...) or of Motion (root, rotations)."""
    with np.load(path) as data:
        if "root_pos" in data:
            quaternions = data["local_quat_wxyz"].astype(np.float64)
            quaternions /= np.linalg.norm(quaternions, axis=-1, keepdims=True)
            rest = data["rest_joints"].astype(np.float64)
            return Motion(
                data["root_pos"].astype(np.float64), quaternions, float(data["fps"]), rest_joints=rest
            )
        return Motion(data["root"], data["rotations"], float(data["fps"]), rest_joints=data["rest_joints"])


def cut(motion: Motion, start: float, end: float | None) -> Motion:
    """Return a motion from start to end, seconds; None: to the last frame."""
    part = slice(int(start * motion.fps), None if end is None else int(end * motion.fps) + 1)
    take = lambda a: None if a is None else a[part]
    return replace(
        motion,
        root=motion.root[part],
        rotations=motion.rotations[part],
        contacts=take(motion.contacts),
        actions=take(motion.actions),
        interaction_start=None,
    )


def look(
    motions: Motion | Sequence[Motion],
    out: str | Path,
    *,
    triangles: np.ndarray | None = None,
    follow: bool = False,
    count: int = 12,
    movie: str | Path | None = None,
    size: tuple[int, int] = (320, 320),
) -> Path:
    """Render motions on one stage as a contact sheet PNG; the camera looks at the first one.

    triangles: furniture (F, 3, 3), metres, network frame. follow: close-ups that turn with the character.
    movie: path of an additional MP4 of the front view.
    """
    from ..samp_addon.blender.render import contact_sheet, stage
    from ..samp_addon.blender.render.movie import write_movie

    motions = [motions] if isinstance(motions, Motion) else list(motions)
    scene, figures = stage.build(motions, triangles)
    track = contact_sheet.Track.of(motions[0])

    def show(frame: int) -> None:
        for figure in figures:
            figure.show(frame)

    views = contact_sheet.CLOSE_VIEWS if follow else contact_sheet.VIEWS
    keywords = {"fps": motions[0].fps, "count": count, "size": size, "views": views}
    sheet = contact_sheet.contact_sheet(scene, track, show, out, **keywords)
    if movie is not None:
        frames = range(len(track.pelvis))
        made = contact_sheet.pictures(scene, track, frames, show, views[0], size=(480, 360))
        write_movie(movie, made, motions[0].fps)
    stage.clear(scene)
    return sheet


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    parser = argparse.ArgumentParser(prog="look", description=__doc__.splitlines()[0])
    parser.add_argument("motions", nargs="+", type=Path, metavar="MOTION.npz")
    parser.add_argument("out", type=Path, metavar="OUT.png")
    parser.add_argument(
        "--object", type=Path, metavar="TRIANGLES.npy", help="furniture (F, 3, 3), network frame"
    )
    parser.add_argument("--follow", action="store_true", help="close-ups that turn with the character")
    parser.add_argument("--count", type=int, default=12, help="number of frames on the sheet")
    parser.add_argument("--from", dest="start", type=float, default=0.0, metavar="SECONDS")
    parser.add_argument("--to", dest="end", type=float, metavar="SECONDS")
    parser.add_argument("--movie", type=Path, metavar="OUT.mp4")
    options = parser.parse_args(arguments)
    motions = [cut(load_motion(path), options.start, options.end) for path in options.motions]
    triangles = None if options.object is None else np.load(options.object)
    look(
        motions,
        options.out,
        triangles=triangles,
        follow=options.follow,
        count=options.count,
        movie=options.movie,
    )
    print(options.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
