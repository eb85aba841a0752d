"""Windows of 64 frames in a row, each drawn until it stays where a body can be (sections 3.2 and 6.2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch

from ....models.scene_gan import height_map, kinematics
from ....models.scene_gan.networks import SceneGan
from ... import rotation
from ...easing import smoothstep
from ...errors import SampError
from ...torch_threads import single_thread
from .frame import ViewFrame
from .ground import Ground

OVERLAP = 12
"""Frames of the next window that are blended with the last ones of the window before it."""
EASED = 10
"""Frames over which a window turns from the motion before it to what the network generated."""
PRESSED, EVERY = 0.005, 4
"""Metres by which joints may be in furniture, see Ground.pressed, in each EVERY-th frame."""
OFF_FLOOR = [k for k in range(kinematics.JOINTS) if k not in (7, 8, 10, 11)]
"""All joints but ankles and feet, which are close to the floor."""
TOLERATED = 0.02
"""Share of a window's frames that may be beside the navmesh."""


@dataclass(frozen=True)
class Improvised:
    """root: (T, 3). rotations: (T, 22, 4). draws: how many windows were drawn in all; windows: how many were kept."""

    root: np.ndarray
    rotations: np.ndarray
    draws: int
    windows: int


class Improviser:
    """Draws windows in a scene.

    heights: (1, 1, X, Z) tensor, corner (1, 2) and cell of the room's heights, for networks that see height maps.
    """

    def __init__(
        self, networks: SceneGan, frame: ViewFrame, ground: Ground, rest: np.ndarray,
        heights: tuple[torch.Tensor, torch.Tensor, float] | None = None,
    ) -> None:  # fmt: skip
        self.networks, self.frame, self.ground, self.rest, self.heights = (
            networks,
            frame,
            ground,
            rest,
            heights,
        )

    @torch.inference_mode()
    def improvise(
        self, root: np.ndarray, rotations: np.ndarray, frames: int, draws: int, seed: int,
        progress: Callable[[float], None],
    ) -> Improvised:  # fmt: skip
        """Return ``frames`` frames that go on from two frames, root (2, 3) and rotations (2, 22, 4).

        The first one returned is the second of these. draws: most draws of each window. Raises SampError where none of
        them stays on free floor or on something to sit on.
        """
        random = torch.Generator().manual_seed(seed)
        used = windows = 0
        begun = len(root) - 1
        with single_thread():
            while len(root) < begun + frames:
                progress((len(root) - begun) / frames)
                at = len(root) - 1 - (OVERLAP if windows else 0)
                at = max(at, 1)
                made, quats, count = self._window(
                    root[at - 1 : at + 1], rotations[at - 1 : at + 1], draws, random
                )
                root, rotations = joined(root, rotations, made, quats, at)
                used, windows = used + count, windows + 1
        last = begun + frames
        return Improvised(root[begun:last], rotation.continuous(rotations[begun:last]), used, windows)

    def _window(
        self, root: np.ndarray, rotations: np.ndarray, draws: int, random: torch.Generator
    ) -> tuple[np.ndarray, np.ndarray, int]:
        """Return the first of ``draws`` windows that stays where it may be and out of furniture, or nearly: root
        (65, 3), rotations, its number."""
        floor = float(self.ground.floor(root[1:] - [0.0, self.ground.standing, 0.0])[0])
        start = self.frame.start(root, rotations, floor, self.rest, draws)
        scene = self._scene(root[1]).expand(draws, -1)
        roots, quats, joints = self.frame.to_scene(self.networks.draw(scene, start, random))
        wrong = np.array([self.ground.wrong(way[1:], floor) for way in roots])
        good = np.flatnonzero(wrong <= TOLERATED)
        if not len(good):
            raise SampError(
                f"None of {draws} draws stays on free floor; try another seed, or move the character or the camera."
            )
        best, least = good[0], np.inf
        for number in good:
            depth = round(self.ground.pressed(joints[number][1::EVERY][:, OFF_FLOOR]), 3)
            if depth < least:
                best, least = number, depth
            if depth <= PRESSED:
                break
        return *continued(roots[best], quats[best], root, rotations), int(best) + 1

    def _scene(self, place: np.ndarray) -> torch.Tensor:
        """Return the scene feature (1, scene) around a place."""
        kind = self.networks.settings.view
        if kind != "height":
            return self.networks.encoder(self.frame.picture(place, kind))
        grids, corner, cell = self.heights
        at = torch.as_tensor(place[None, [0, 2]], dtype=torch.float32)
        yaw = torch.tensor([self.frame.yaw], dtype=torch.float32)
        return self.networks.encoder(height_map.around(grids, corner, cell, at, yaw))


def continued(
    root: np.ndarray, quats: np.ndarray, before: np.ndarray, turned: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return a window (T, 3), (T, 22, 4), whose first frame is given, without the jump that follows it.

    before, turned: the given frame and the one before it, (2, 3) and (2, 22, 4), whose velocity is kept at first.
    """
    weight = 1 - smoothstep(np.arange(len(root) - 1) / EASED)
    moved = 2 * before[1] - before[0] - root[1]
    step = rotation.multiply(rotation.conjugate(turned[0]), turned[1])
    missing = rotation.multiply(rotation.multiply(turned[1], step), rotation.conjugate(quats[1]))
    turns = rotation.from_axis_angle(weight[:, None, None] * rotation.to_axis_angle(missing))
    return (
        np.concatenate([root[:1], root[1:] + weight[:, None] * moved]),
        np.concatenate([quats[:1], rotation.multiply(turns, quats[1:])]),
    )


def joined(
    root: np.ndarray, rotations: np.ndarray, made: np.ndarray, quats: np.ndarray, at: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return frames up to now followed by a window whose given frame is frame ``at``; what overlaps is cross-faded."""
    overlap = len(root) - 1 - at
    if overlap == 0:
        return np.concatenate([root, made[1:]]), np.concatenate([rotations, quats[1:]])
    weight = smoothstep(np.arange(1, overlap + 1) / (overlap + 1))[:, None]
    mixed = root[at + 1 :] * (1 - weight) + made[1 : overlap + 1] * weight
    turned = rotation.slerp(rotations[at + 1 :], quats[1 : overlap + 1], weight)
    return (
        np.concatenate([root[: at + 1], mixed, made[overlap + 1 :]]),
        np.concatenate([rotations[: at + 1], turned, quats[overlap + 1 :]]),
    )


def frames_of(seconds: float, fps: float = 30.0) -> int:
    """Return the number of frames of a take, the first one included."""
    return int(round(seconds * fps)) + 1
