"""Windows of 64 frames in a row, each drawn until it stays where a body can be (sections 3.2 and 6.2), or cut."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch

from ....models.scene_gan import height_map
from ....models.scene_gan.networks import SceneGan
from ... import rotation
from ...easing import smoothstep
from ...errors import SampError
from ...motion import Motion
from ...skeleton import BODY_COUNT
from ...torch_threads import single_thread
from . import liveliness, placing
from .frame import ViewFrame
from .judging import Judge

WINDOW = 64
"""Frames of a window after the given one."""
USED = 44
"""Frames of a window that a take uses at most: towards its end the networks lose the phase of the gait, and steps fade.
"""
OVERLAP = 12
"""Frames of the next window that are blended with the last ones of the window before it."""
EASED = 10
"""Frames over which a window turns from the motion before it to what the network generated."""
CHOICE = 3
"""Windows that the networks draw for each one that may be judged: with few of them, none sets off from standing."""
GOLDEN = (5**0.5 - 1) / 2
"""Step between the shares of successive seeds; its multiples fill the range from 0 to 1 evenly."""
JOLTS = 30.0
"""Metres of difference in the distance covered that a metre of `jolt` weighs."""
UNSEEN, SEEN_EVERY = 1.0, 8
"""Metres of difference in the distance covered that a window out of the picture weighs, and the step, in frames,
between those in which it is looked for."""
SHORTEST = 8
"""Least number of frames by which a window makes the take longer; a shorter one is drawn again."""
MARGIN = 4
"""Frames between the end of a cut window and the first one that cannot be followed."""
MOST_BACK = 6
"""How often the last window of a take is removed and drawn again before the take is given up."""
PRESSED = 0.004
"""Metres of a window's bodies in furniture, on average, up to which no better draw is looked for."""


@dataclass(frozen=True)
class Improvised:
    """root: (T, 3). rotations: (T, 22, 4). draws: how many draws were judged in all. windows: for how many windows,
    those that were drawn again included."""

    root: np.ndarray
    rotations: np.ndarray
    draws: int
    windows: int


class Improviser:
    """Draws windows in a scene.

    heights: (1, 1, X, Z) tensor, corner (1, 2) and cell of the room's heights, for networks that see height maps.
    """

    def __init__(
        self, networks: SceneGan, frame: ViewFrame, judge: Judge, rest: np.ndarray,
        heights: tuple[torch.Tensor, torch.Tensor, float] | None = None,
    ) -> None:  # fmt: skip
        self.networks, self.frame, self.judge, self.rest, self.heights = networks, frame, judge, rest, heights

    @torch.inference_mode()
    def improvise(
        self, root: np.ndarray, rotations: np.ndarray, frames: int, draws: int, seed: int,
        progress: Callable[[float], None],
    ) -> Improvised:  # fmt: skip
        """Return ``frames`` frames that go on from two frames, root (2, 3) and rotations (2, 22, 4).

        The first one returned is the second of these. draws: most windows that are judged for each one. A window is cut
        where it cannot be followed further; where that leaves too little, the one before it is drawn again. Raises
        SampError where that has been done MOST_BACK times.
        """
        random = torch.Generator().manual_seed(seed)
        used = windows = back = 0
        begun = len(root) - 1
        with single_thread():
            while len(root) < begun + frames:
                progress((len(root) - begun) / frames)
                at = max(len(root) - 1 - OVERLAP, begun)
                made, quats, count = self._window(
                    root[at - 1 : at + 1], rotations[at - 1 : at + 1], at - begun, draws, random, seed
                )
                used, windows = used + count, windows + 1
                if at + len(made) < len(root) + SHORTEST:
                    back += 1
                    if back > MOST_BACK:
                        raise SampError(
                            f"No draw out of {draws} stays on free floor and clear of others; try another seed or more "
                            "draws, or move the character or the camera."
                        )
                    kept = max(at - (USED - OVERLAP), begun) + 1
                    root, rotations = root[:kept], rotations[:kept]
                    continue
                root, rotations = joined(root, rotations, made, quats, at)
        last = begun + frames
        return Improvised(root[begun:last], rotation.continuous(rotations[begun:last]), used, windows)

    def _window(
        self,
        root: np.ndarray,
        rotations: np.ndarray,
        first: int,
        draws: int,
        random: torch.Generator,
        seed: int,
    ) -> tuple[np.ndarray, np.ndarray, int]:
        """Return the window that can be followed for the longest time, cut there: root (T, 3), rotations (T, 22, 4),
        and how many of ``draws`` were judged.

        root: (2, 3), rotations: (2, 22, 4) of the frames that the window goes on from. first: number, in the take, of
        the second of these. The networks draw CHOICE times as many windows. Those most like captured motion, see
        liveliness.py, are judged first, until one can be followed to its end out of furniture.
        """
        ground = self.judge.ground
        floor = float(ground.floor(root[1:] - [0.0, ground.standing, 0.0])[0])
        start = self.frame.start(root, rotations, floor, self.rest, CHOICE * draws)
        scene = self._scene(root[1]).expand(CHOICE * draws, -1)
        motions = self.networks.draw(scene, start, random)
        roots, quats = self.frame.to_scene(motions)
        far = self._far(root, first, random, seed)
        unlike = liveliness.unlike(motions.joints.double().numpy(), roots, far)
        unlike += JOLTS * jolt(root, rotations, roots[:, 1], quats[:, 1]) + UNSEEN * self._unseen(
            roots, floor
        )
        best, least, judged = None, (np.inf, np.inf), 0
        for number in np.argsort(unlike)[:draws]:
            way, turned = continued(roots[number], quats[number], root, rotations)
            verdict = self.judge.of(way, turned, floor, first)
            judged += 1
            rank = (-verdict.frames, round(verdict.depth, 3))
            if rank < least:
                best, least = (way, turned), rank
            if verdict.frames == WINDOW and verdict.depth <= PRESSED:
                break
        kept = -least[0]
        end = min(USED, kept if kept == WINDOW else max(kept - MARGIN, 0)) + 1
        return best[0][:end], best[1][:end], judged

    def _far(self, root: np.ndarray, first: int, random: torch.Generator, seed: int) -> float:
        """Return how far the body should go in a window; arguments as for `_window`.

        Successive seeds begin a take that begins standing with ways that are spread evenly over those of captured
        bodies.
        """
        speed = self.judge.fps * float(np.linalg.norm((root[1] - root[0])[[0, 2]]))
        if not first and speed < liveliness.SPEEDS[0]:
            return liveliness.wanted(None, seed * GOLDEN % 1.0)
        return liveliness.wanted(speed, float(torch.rand(1, generator=random)))

    def _unseen(self, roots: np.ndarray, floor: float) -> np.ndarray:
        """Return the share (B,) of each window, pelvis (B, 65, 3), in which the body is out of the picture."""
        if self.frame.view is None:
            return np.zeros(len(roots))
        return 1 - placing.seen_from(self.frame.view, roots[:, ::SEEN_EVERY], floor).mean(-1)

    def _scene(self, place: np.ndarray) -> torch.Tensor:
        """Return the scene feature (1, scene) around a place."""
        kind = self.networks.settings.view
        if kind != "height":
            return self.networks.encoder(self.frame.picture(place, kind))
        grids, corner, cell = self.heights
        at = torch.as_tensor(place[None, [0, 2]], dtype=torch.float32)
        yaw = torch.tensor([self.frame.yaw], dtype=torch.float32)
        return self.networks.encoder(height_map.around(grids, corner, cell, at, yaw))


def jolt(root: np.ndarray, rotations: np.ndarray, roots: np.ndarray, quats: np.ndarray) -> np.ndarray:
    """Return how far the joints of poses (B, 3), (B, 22, 4) are, on average, from where the motion before leads (B,).

    root: (2, 3), rotations: (2, 22, 4) of the two frames before. Metres.
    """
    joints = lambda place, turns: Motion(place, turns).forward_kinematics()[0][:, :BODY_COUNT]
    before = joints(root, rotations)
    return np.linalg.norm(joints(roots, quats) - (2 * before[1] - before[0]), axis=-1).mean(-1)


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
