"""From jobs and a saved copy of the scene to a submitted bundle. Needs no Blender: it runs in a thread."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ....pipeline.cast.cast import Cast
from ....pipeline.job import Job
from ....progress import Progress
from . import bundle, engines, lines, packing

SCENE = "scene.blend"


@dataclass(frozen=True)
class Sending:
    """What is to be sent. folder: holds the copy of the scene. name: of the job in the farm's manager. texts: lines of
    the jobs file. home: folder of the artist's file. linked: files that the scene links."""

    folder: Path
    name: str
    texts: Sequence[str]
    engine: engines.Engine
    home: Path
    linked: tuple[Path, ...] = ()

    def finish(self, progress: Progress) -> str:
        """Pack linked files, write the bundle and submit it; return the sentence to report. Raise SampError."""
        scene, advice, texts = self.folder / SCENE, "", list(self.texts)
        if self.linked and packing.available():
            scene = packing.pack(scene, self.home, list(self.linked), progress)
            texts = [lines.with_scene(text, scene.relative_to(self.folder).as_posix()) for text in texts]
        elif self.linked:
            advice = (
                f" The scene links {len(self.linked)} other files, which the workers must see under the same names; "
                f"with the Python package {packing.DISTRIBUTION} they are packed."
            )
        made = bundle.Bundle(self.folder, self.name, scene, len(texts))
        bundle.write(made, texts, self.engine.workers)
        return engines.submit(self.engine, made, progress) + advice


def texts(
    jobs: Sequence[Job | Cast], takes: int, per_line: int, blends: bool = False, previews: bool = False
) -> list[str]:
    """Return the lines for jobs: each makes `takes` takes, `per_line` at a time. Raise SampError.

    blends: whether each line also leaves a .blend. previews: whether each take gets a picture.
    """
    found: list[str] = []
    for job in jobs:
        for piece in lines.pieces(job, takes, per_line):
            files = {"scene": SCENE, "npz": f"{bundle.OUTPUT}/npz"}
            if blends:
                files["output"] = f"{bundle.OUTPUT}/blend/line_{len(found) + 1:05}.blend"
            if previews:
                files["preview"] = f"{bundle.OUTPUT}/preview"
            found.append(lines.line(piece, files))
    return found
