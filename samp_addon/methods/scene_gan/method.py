"""Scene GAN as a method: what a camera sees and where the character stands -> windows of motion -> a finished take."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...errors import PathError, SampError, UsageError
from ..method import Draw, Option
from .load_networks import HEIGHT, PICTURE, installed, trained

if TYPE_CHECKING:
    import numpy as np

    from ....models.scene_gan.networks import SceneGan
    from ...progress import Progress
    from ...scene.navmesh.navmesh import NavMesh
    from ..scene_view import SceneView
    from ..step import Step
    from ..take import Failure, Take

# Numpy, scipy and torch are imported when a take is generated: the panel asks for a method's name at every redraw.

SECONDS = 4.0
DRAWS = 8


class SceneGanMethod:
    """Scene-aware Generative Network (Wang et al. 2021).

    networks: others than the trained ones.
    """

    name = "scene_gan"
    label = "Improvise"
    description = "Do something that fits what a camera sees, without a target"
    actions: tuple[str, ...] = ()
    needs = frozenset({"geometry", "start", "camera", "others"})
    options = (
        Option("camera", "name of the camera that sees the room; left out, the scene's active one", kind=str,
               metavar=("NAME",)),
        Option("seconds", "length of the take", default=SECONDS, minimum=1.0, maximum=120.0, metavar=("S",)),
        Option("draws", "most tries for each two seconds of the take", kind=int, default=DRAWS, minimum=1,
               maximum=64),
    )  # fmt: skip
    batch_size = 4

    def __init__(self, networks: SceneGan | None = None) -> None:
        self._networks = networks

    def installed(self) -> bool:
        """Return whether the trained weights are there."""
        return self._networks is not None or installed() or installed(name=HEIGHT)

    def check(self, step: Step) -> None:
        """Raise UsageError for a target or a place: nothing leads there."""
        if step.target:
            raise UsageError("The method 'scene_gan' goes to no target; leave --target out.")
        if step.to is not None or step.via:
            raise UsageError("The method 'scene_gan' goes to no place; leave --to and --via out.")

    def load(self) -> None:
        """Load the networks."""
        self._tools(installed())

    def generate(
        self, step: Step, scene: SceneView, draws: Sequence[Draw], progress: Progress
    ) -> tuple[list[Take], list[Failure]]:
        """Return a take for each draw, and the failures; see Method.generate."""
        from ...clock import Clock
        from ...progress import SubProgress
        from ..take import Failure
        from .making import Maker

        clock = Clock()
        progress("Loading", 0.0)
        with clock.stage("load"):
            networks = self._tools(scene.camera is not None)
        progress("Finding the floor", 0.0)
        with clock.stage("navmesh"):
            try:
                maker = Maker(networks, scene, walkable(scene))
            except PathError as error:
                raise SampError(str(error)) from error
        takes, failures = [], []
        for number, draw in enumerate(draws):
            part = SubProgress(progress, number / len(draws), 1 / len(draws), "Improvising")
            try:
                takes.append(maker.take(step, draw, clock, part))
            except SampError as error:
                failures.append(Failure(draw.seed, str(error)))
        return takes, failures

    def _tools(self, picture: bool) -> SceneGan:
        """Return the networks for a scene with or without a camera's picture.

        Raise SampError where there are none for it.
        """
        if self._networks is not None:
            return self._networks
        if not installed(name=HEIGHT):
            if not picture:
                raise SampError("The scene has no active camera; add one that sees the room, or name one.")
            return trained()
        return trained(name=PICTURE if picture and installed() else HEIGHT)


def walkable(scene: SceneView) -> NavMesh:
    """Return the walkable ground around the character, or around what the camera sees."""
    from dataclasses import replace

    if scene.start is not None or scene.after or scene.camera is None:
        return scene.navmesh
    return replace(scene, via=(), start=(_middle(scene), 0.0)).navmesh


def _middle(scene: SceneView) -> np.ndarray:
    """Return the middle (3,) of what the camera sees."""
    view = scene.camera
    rows, columns = view.depth.nonzero()
    if not len(rows):
        return view.eye
    import numpy as np

    ahead = view.depth[rows, columns]
    width = view.depth.shape[1]
    right = (columns / width - view.lens[1]) / view.lens[0] * ahead
    down = (rows / width - view.lens[2]) / view.lens[0] * ahead
    points = np.stack([right, down, ahead], -1) - view.extrinsics[:3, 3]
    return np.median(points @ view.extrinsics[:3, :3], axis=0)


METHOD = SceneGanMethod()
