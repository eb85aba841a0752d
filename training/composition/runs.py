"""Long runs from standing to standing, joined from short captured starts, strides and stops."""

from __future__ import annotations

from collections import Counter

import numpy as np
from scipy.spatial import cKDTree

from ..mocap.augment import bent, paced, relocked
from ..mocap.clip_files import Clip
from .checks import fault
from .stitch import join, pose_features
from .walks import STANDING

ALIKE = 1.2  # largest distance of pose features at a join
STRIDES = (0, 5)  # excerpts of running between start and stop
SHORTEST = 9  # least number of frames kept of each excerpt
PACE = (0.8, 1.15)
CURVATURE = 0.3  # rad/m, standard deviation
RUN_UP = 60  # frames kept before the running


class RunComposer:
    """Compose long runs from short ones; report counts kept and dropped ones by reason."""

    def __init__(self, clips: list[Clip], seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.report: Counter[str] = Counter()
        self.clips = [clip for clip in clips if (clip.labels == "run").sum() >= 20]
        features, self.where = [], []
        for number, clip in enumerate(self.clips):
            frames = np.flatnonzero(self._running(clip))
            features.append(pose_features(clip.root, clip.rotations)[frames])
            self.where += [(number, int(frame)) for frame in frames]
        self.features = np.concatenate(features)
        self.tree = cKDTree(self.features)
        self.index = {place: k for k, place in enumerate(self.where)}
        self.starts = [k for k, clip in enumerate(self.clips) if self._sets_off(clip)]
        self.stops = [k for k, clip in enumerate(self.clips) if self._comes_to_stand(clip)]

    @staticmethod
    def _running(clip: Clip) -> np.ndarray:
        return (clip.labels == "run") & ~clip.bad

    @staticmethod
    def _sets_off(clip: Clip) -> bool:
        running = np.flatnonzero(clip.labels == "run")
        return clip.labels[0] in STANDING and not clip.bad[: running[0] + SHORTEST].any()

    @staticmethod
    def _comes_to_stand(clip: Clip) -> bool:
        running = np.flatnonzero(clip.labels == "run")
        return clip.labels[-1] in STANDING and not clip.bad[running[-1] - SHORTEST :].any()

    def compose(self) -> Clip | None:
        """Return a run from standing to standing, or None."""
        number = int(self.rng.choice(self.starts))
        run = self.clips[number]
        begins = int(np.flatnonzero(run.labels == "run")[0])
        frame = begins + SHORTEST
        made = run.cut(max(0, begins - RUN_UP), frame + 1)
        for left in range(int(self.rng.integers(*STRIDES)), -1, -1):
            found = self._next(number, frame, last=left == 0)
            if found is None:
                self.report["no run matched"] += 1
                return None
            number, first, frame = found
            made = join(made, self.clips[number].cut(first, frame + 1))
        made = bent(paced(made, self.rng.uniform(*PACE)), self.rng.normal(0, CURVATURE))
        made = relocked(made)
        why = fault(made)
        self.report[why or "kept"] += 1
        return made if why is None else None

    def _next(self, number: int, frame: int, last: bool) -> tuple[int, int, int] | None:
        """Return (clip, first frame, last frame) of an excerpt that continues a frame of running, or None."""
        at = self.index.get((number, frame))
        if at is None:
            return None
        distance, near = self.tree.query(self.features[at], k=60)
        choices = []
        for d, k in zip(distance, near, strict=True):
            clip, first = self.where[k]
            if d > ALIKE or clip == number:
                continue
            if last and clip in self.stops:
                choices.append((clip, first, len(self.clips[clip]) - 1))
            elif not last and (stretch := self._stretch(clip, first)) - first >= SHORTEST:
                choices.append((clip, first, stretch))
        return choices[self.rng.integers(len(choices))] if choices else None

    def _stretch(self, clip: int, first: int) -> int:
        """Return the last frame of the clean running that contains ``first``."""
        spoilt = np.flatnonzero(~self._running(self.clips[clip])[first:])
        return first + int(spoilt[0]) - 1 if len(spoilt) else len(self.clips[clip]) - 1
