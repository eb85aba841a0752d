"""A batch of training rollouts (section 3.4): the frame of each, and its next input (equation 5)."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from .....models import state
from . import drift
from .frames import Frames

# At run time, the path to the seat is planned and the last steps are left to the network. Training does the same: the
# predicted path is used within a distance of the seat drawn from this range, and always for a share of the rollouts.
OWN_PATH = (0.4, 1.4)  # metres
ALWAYS_OWN = 0.25
NEVER = 1e9  # metres; greater than any distance to a seat
LATEST = 6  # largest offset of a rollout from its clock, frames
CLOCK_GAIN = (
    0.03  # share of a delay by which the clock is adjusted in every frame: paces differ from the captured one
)
KEEP_BIAS = 0.9  # factor on the distance to the next frame in the choice between it and its neighbours
TRUTH_FACTOR = (0.4, 1.6)
START_DRIFT = 0.1  # metres and radians; standard deviation of the drift at the start of a rollout
FULL_DRIFT_DISTANCE = 1.5  # metres to the goal beyond which the start drift has its full size
MAX_DRIFT = 0.6  # metres of drift beyond which a rollout is restarted; twice as many radians
SHOWN_POSTURES = 0.75  # share of the rollouts that know the posture of the rest; the others find one


@dataclass
class Progress:
    """Quantities that change during a training, as tensors () on the device.

    truth: probability that the true state is the next input. longest: length of the longest rollouts, frames.
    """

    truth: torch.Tensor
    longest: torch.Tensor


@dataclass
class Draws:
    """Random numbers of one step: uniform (B, 8), normal (B, 3), and uniform for the start frames (B,)."""

    uniform: torch.Tensor
    normal: torch.Tensor
    start: torch.Tensor

    @classmethod
    def new(cls, count: int, device: torch.device) -> Draws:
        """Draw the numbers for B rollouts."""
        return cls(
            torch.rand(count, 8, device=device),
            torch.randn(count, 3, device=device),
            torch.rand(count, device=device, dtype=torch.float64),
        )


class Rollouts:
    """B rollouts, each of its own age. A rollout that ends is replaced by a new one.

    x: (B, 647) the next inputs. at: (B,) the present captured frames. clock: (B,) the frames without any delay. own:
    (B, 3) roots. age, length: (B,) frames. truth_factor: (B, 1) multiplies the probability of the truth. reach: (B, 1)
    distance to the seat, metres, within which the predicted future path is used. piece: (B,) column of the piece of
    furniture. shown: (B,) whether the posture of the rest is known. tally: (2,) sums over the steps of the mean drift
    in metres and of the share of lost rollouts.
    """

    def __init__(self, frames: Frames, count: int, window: int, drifts: bool = True) -> None:
        self.frames, self.count, self.window, self.drifts = frames, count, window, drifts
        device = frames.device
        self.progress = Progress(torch.ones((), device=device), torch.full((), float(window), device=device))
        draws = Draws.new(count, device)
        self.at, self.own, drawn = self._draw_starts(draws)
        self.clock = self.at.float()
        self.length = torch.full_like(self.at, window)
        self.age = (draws.uniform[:, 6] * window).long()
        self.truth_factor, self.reach, self.piece, self.shown = drawn
        self.x = self._observed()
        self.tally = torch.zeros(2, device=device)

    def _draw_starts(self, draws: Draws) -> tuple[torch.Tensor, torch.Tensor, tuple[torch.Tensor, ...]]:
        """Return start frames (B,), start roots (B, 3), and the values that are drawn once for each rollout."""
        frames, chance = self.frames, draws.uniform
        first = frames.sample_starts(draws.start)
        captured = frames.roots[first]
        left = (frames.goal_distance(first, captured) / FULL_DRIFT_DISTANCE).clamp(0.1, 1.0)[:, None]
        aside = START_DRIFT * left * draws.normal[:, :3] * float(self.drifts)
        reach = uniform(chance[:, :1], *OWN_PATH).masked_fill(chance[:, 1:2] < ALWAYS_OWN, NEVER)
        truth_factor = uniform(chance[:, 2:3], *TRUTH_FACTOR)
        piece = frames.sample_pieces(first, chance[:, 3])
        shown = chance[:, 7] < SHOWN_POSTURES
        drawn = (truth_factor, reach, piece, shown)
        return first, drift.displace(captured, aside), drawn

    def _states(self, frames: torch.Tensor) -> torch.Tensor:
        return self.frames.states[frames].float()

    def _observed(self) -> torch.Tensor:
        """Return the captured states (B, 647) as seen by the rollouts."""
        return drift.observe(self._states(self.at), self.drift(), self.frames.return_lengths(self.at))

    def drift(self) -> torch.Tensor:
        """Return the drift (B, 3) of each rollout; see drift.py."""
        apart = drift.offset(self.own, self.frames.roots[self.at])
        return apart if self.drifts else torch.zeros_like(apart)

    def targets(self) -> torch.Tensor:
        """Return the targets (B, 647) in the root frames of the rollouts."""
        frames = self.frames
        return drift.correct(frames.targets[self.at].float(), self.drift(), frames.return_lengths(self.at))

    def object_features(self) -> torch.Tensor:
        """Return the features (B, 2048 + 9) of furniture and posture in the root frames of the rollouts."""
        return self.frames.object_features(self.at, self.own, self.piece, self.shown)

    def styles(self) -> torch.Tensor:
        """Return the styles (B, 16) of the sequences."""
        return self.frames.styles[self.frames.sequence[self.at]]

    def advance(self, predicted: torch.Tensor, scale: torch.Tensor, draws: Draws) -> None:
        """Advance by one frame, from the truth or from the predictions (B, 647).

        scale: (264,) standard deviations of the pose.
        """
        fed = state.reroot(predicted)
        self.own.copy_(drift.displace(self.own, drift.root_step(predicted)))
        self.age += 1
        following = (self.at + 1).clamp(max=len(self.frames) - 1)
        over = self.frames.sequence[following] != self.frames.sequence[self.at]
        at = self._aligned(fed, following, self.clock + 1, scale)
        self.clock.copy_(self.clock + 1 + CLOCK_GAIN * (at - self.clock - 1))
        self.at.copy_(at)
        apart = self.drift()
        lost = (
            (apart[:, :2].norm(dim=-1) > MAX_DRIFT)
            | (apart[:, 2].abs() > 2 * MAX_DRIFT)
            | ~fed.isfinite().all(-1)
        )
        metres = apart[:, :2].norm(dim=-1).nan_to_num(MAX_DRIFT).clamp(max=MAX_DRIFT)
        self.tally += torch.stack([metres.mean(), lost.float().mean()])
        restarted = over | lost | (self.age >= self.length) | ~self.frames.usable[self.at]
        self._restart(restarted, draws)
        self.x.copy_(self._input(fed, restarted[:, None], draws.uniform))

    def _aligned(
        self, fed: torch.Tensor, at: torch.Tensor, clock: torch.Tensor, scale: torch.Tensor
    ) -> torch.Tensor:
        """Return the frames (B,) near ``at``, within LATEST of the clock, whose true poses are nearest to ``fed``.

        Steps slightly earlier or later than the captured ones are not wrong. With targets fixed to the clock, the
        network would learn the mean of poses in different phases: ever smaller steps.
        """
        frames, best, nearest = self.frames, at, None
        low, high = (clock - LATEST).round().long(), (clock + LATEST).round().long()
        for shift in (0, -1, 1):
            near = torch.minimum(torch.maximum(at + shift, low), high).clamp(0, len(frames) - 1)
            near = torch.where(frames.usable[near] & (frames.sequence[near] == frames.sequence[at]), near, at)
            pose = frames.states[near, state.POSE].float()
            distance = ((pose - fed[:, state.POSE]) / scale).square().mean(-1)
            if nearest is None:
                best, nearest = near, distance * KEEP_BIAS
            else:
                best = torch.where(distance < nearest, near, best)
                nearest = torch.minimum(distance, nearest)
        return best

    def _restart(self, restarted: torch.Tensor, draws: Draws) -> None:
        first, own, drawn = self._draw_starts(draws)
        spread = draws.uniform[:, 6] * (self.progress.longest - self.window)
        self.at.copy_(torch.where(restarted, first, self.at))
        self.own.copy_(torch.where(restarted[:, None], own, self.own))
        self.clock.copy_(torch.where(restarted, first.float(), self.clock))
        self.length.copy_(torch.where(restarted, self.window + spread.long(), self.length))
        self.age.copy_(torch.where(restarted, 0, self.age))
        present = (self.truth_factor, self.reach, self.piece, self.shown)
        for kept, new in zip(present, drawn, strict=True):
            kept.copy_(torch.where(restarted.reshape(-1, *(1,) * (kept.dim() - 1)), new, kept))

    def _input(self, fed: torch.Tensor, restarted: torch.Tensor, chance: torch.Tensor) -> torch.Tensor:
        """Return the next inputs (B, 647). restarted: (B, 1) rollouts that start from the truth. chance: (B, 7)."""
        truth_share = self.progress.truth
        truth = self._observed()
        keep = restarted | (chance[:, 5:6] < truth_share * self.truth_factor) | (truth_share >= 1)
        distance = self.frames.goal_distance(self.at, self.own)[:, None]
        planned = (self.reach < NEVER) & (
            ~self.frames.seated_goal[self.at][:, None] | (distance > self.reach)
        )
        follow_plan = restarted | planned | (keep & (chance[:, 6:7] < truth_share))
        ahead = lambda s: s[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)[:, state.NOW + 1 :, :4]
        path = torch.where(follow_plan[..., None], ahead(truth), ahead(fed))
        x = torch.where(keep, truth, fed)
        x[:, state.GOAL] = truth[:, state.GOAL]
        x[:, state.TRAJECTORY].view(-1, state.SAMPLES, 9)[:, state.NOW + 1 :, :4] = path
        return state.consistent(x)


def uniform(chance: torch.Tensor, low: float, high: float) -> torch.Tensor:
    """Map numbers from the range 0 to 1 to the range low to high."""
    return low + (high - low) * chance
