"""Rollouts in flight (section 3.4): where each is, and what the next step of each begins with (equation 5)."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from .....models import state
from .....models.motion_net import LATENT
from . import drift
from .frames import Frames

# At run time the way to the seat is planned, and the last steps are the network's own. So they are in training:
# within a distance of the seat drawn from this range, and all along for a share of the rollouts.
OWN_PATH = (0.4, 1.4)  # metres
ALWAYS_OWN = 0.25
NEVER = 1e9  # metres: no way to a seat is as long
LATEST = 6  # frames that a rollout may be early or late
FORGIVEN = (
    0.03  # share of that which the clock forgives in every frame: nobody walks at just the captured pace
)
STAY = 0.9  # by which the frame after has to be farther off than its neighbours to be left for one of them
EAGER = (0.4, 1.6)
BEGIN_ASIDE = 0.1  # metres and radians, standard deviation of the drift that a rollout begins with
FULL_WAY = 1.5  # metres to the goal from which it has all of that
LOST = 0.6  # metres of drift at which a rollout begins anew
HELD_WITHIN = (
    -90,
    180,
)  # frames, from its first one, among which a rollout is shown the one that it takes after


@dataclass
class Progress:
    """What changes in the course of a training, as tensors () on the device: the probability of the truth and the
    length of the longest rollouts in frames."""

    truth: torch.Tensor
    longest: torch.Tensor


@dataclass
class Draws:
    """Random numbers of one step: uniform (B, 7), normal (B, 67), and one for the next first frames (B,)."""

    uniform: torch.Tensor
    normal: torch.Tensor
    start: torch.Tensor

    @classmethod
    def new(cls, count: int, device: torch.device) -> Draws:
        """Fresh ones for B rollouts."""
        return cls(
            torch.rand(count, 7, device=device),
            torch.randn(count, 3 + LATENT, device=device),
            torch.rand(count, device=device, dtype=torch.float64),
        )


class Rollouts:
    """B rollouts, each at an age of its own; where one ends, another begins.

    x: (B, 647) the next inputs. at: (B,) the captured frames that they are at; clock: (B,) those that they would be at
    had none been early or late. own: (B, 3) their roots. age, length: (B,) frames. eager: (B, 1) by which the
    probability of the truth is multiplied. reach: (B, 1) metres from the seat within which the future path is the
    prediction's. piece: (B,) which of the fitting pieces. like: (B,) frames that tell what each takes after; noise:
    (B, 64) the draw of what it takes over from there. tally: (2,) sums of the mean drift in metres and of the share of
    rollouts that were lost, over all steps.
    """

    def __init__(self, frames: Frames, count: int, window: int, drifts: bool = True) -> None:
        self.frames, self.count, self.window, self.drifts = frames, count, window, drifts
        device = frames.device
        self.progress = Progress(torch.ones((), device=device), torch.full((), float(window), device=device))
        draws = Draws.new(count, device)
        self.at, self.own, begins = self._beginnings(draws)
        self.clock = self.at.float()
        self.length = torch.full_like(self.at, window)
        self.age = (draws.uniform[:, 6] * window).long()
        self.eager, self.reach, self.piece, self.like, self.noise = begins
        self.x = drift.seen(self._states(self.at), self.drift())
        self.tally = torch.zeros(2, device=device)

    def _beginnings(self, draws: Draws) -> tuple[torch.Tensor, torch.Tensor, tuple[torch.Tensor, ...]]:
        """First frames (B,), first roots (B, 3), and what is drawn once for each rollout."""
        frames, chance = self.frames, draws.uniform
        first = frames.starts_of(draws.start)
        captured = frames.roots[first]
        left = (frames.goal_distance(first, captured) / FULL_WAY).clamp(0.1, 1.0)[:, None]
        aside = BEGIN_ASIDE * left * draws.normal[:, :3] * float(self.drifts)
        reach = between(chance[:, :1], *OWN_PATH).masked_fill(chance[:, 1:2] < ALWAYS_OWN, NEVER)
        eager, piece = between(chance[:, 2:3], *EAGER), frames.pieces_of(first, chance[:, 3])
        drawn = (eager, reach, piece, self._alike(first, chance[:, 4]), draws.normal[:, 3:].clone())
        return first, drift.moved(captured, aside), drawn

    def _alike(self, first: torch.Tensor, chance: torch.Tensor) -> torch.Tensor:
        """Frames (B,) of the same sequences not far from the first ones, usable ones; else the first ones."""
        other = (first + between(chance, *HELD_WITHIN).long()).clamp(0, len(self.frames) - 1)
        fits = self.frames.usable[other] & (self.frames.sequence[other] == self.frames.sequence[first])
        return torch.where(fits, other, first)

    def _states(self, frames: torch.Tensor) -> torch.Tensor:
        return self.frames.states[frames].float()

    def drift(self) -> torch.Tensor:
        """Of each rollout from the captured root (B, 3)."""
        apart = drift.between(self.own, self.frames.roots[self.at])
        return apart if self.drifts else torch.zeros_like(apart)

    def targets(self) -> torch.Tensor:
        """What the network shall say (B, 647), told in the rollouts' own root frames."""
        return drift.followed(self.frames.targets[self.at].float(), self.drift())

    def object_features(self) -> torch.Tensor:
        """Features (B, 2048) of the furniture seen from the rollouts' own roots."""
        return self.frames.object_features(self.at, self.own, self.piece)

    def taken_after(self) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """States, targets (B, 647) and object features (B, 2048) of the frames that the rollouts take after."""
        frames = self.frames
        features = frames.object_features(self.like, frames.roots[self.like], self.piece)
        return self._states(self.like), frames.targets[self.like].float(), features

    def advance(self, predicted: torch.Tensor, scale: torch.Tensor, draws: Draws) -> None:
        """Goes on by one frame: from the truth or from each rollout's own prediction (B, 647).

        scale: (264,) standard deviations of the pose's numbers.
        """
        fed = state.reroot(predicted)
        self.own.copy_(drift.moved(self.own, drift.step_of(predicted)))
        self.age += 1
        following = (self.at + 1).clamp(max=len(self.frames) - 1)
        over = self.frames.sequence[following] != self.frames.sequence[self.at]
        at = self._aligned(fed, following, self.clock + 1, scale)
        self.clock.copy_(self.clock + 1 + FORGIVEN * (at - self.clock - 1))
        self.at.copy_(at)
        apart = self.drift()
        lost = (apart[:, :2].norm(dim=-1) > LOST) | (apart[:, 2].abs() > 2 * LOST) | ~fed.isfinite().all(-1)
        metres = apart[:, :2].norm(dim=-1).nan_to_num(LOST).clamp(max=LOST)
        self.tally += torch.stack([metres.mean(), lost.float().mean()])
        begun = over | lost | (self.age >= self.length) | ~self.frames.usable[self.at]
        self._begin_anew(begun, draws)
        self.x.copy_(self._input(fed, begun[:, None], draws.uniform))

    def _aligned(
        self, fed: torch.Tensor, at: torch.Tensor, clock: torch.Tensor, scale: torch.Tensor
    ) -> torch.Tensor:
        """Frames (B,) near ``at`` whose true poses are nearest to the predicted ones, at most LATEST off the clock.

        A rollout whose steps come a little sooner or later than the captured ones is not wrong. Held to the clock,
        it would be taught the mean of poses in different phases: smaller and smaller steps.
        """
        frames, best, nearest = self.frames, at, None
        low, high = (clock - LATEST).round().long(), (clock + LATEST).round().long()
        for shift in (0, -1, 1):
            near = torch.minimum(torch.maximum(at + shift, low), high).clamp(0, len(frames) - 1)
            near = torch.where(frames.usable[near] & (frames.sequence[near] == frames.sequence[at]), near, at)
            pose = frames.states[near, state.POSE].float()
            distance = ((pose - fed[:, state.POSE]) / scale).square().mean(-1)
            if nearest is None:
                best, nearest = near, distance * STAY
            else:
                best = torch.where(distance < nearest, near, best)
                nearest = torch.minimum(distance, nearest)
        return best

    def _begin_anew(self, begun: torch.Tensor, draws: Draws) -> None:
        first, own, drawn = self._beginnings(draws)
        spread = draws.uniform[:, 6] * (self.progress.longest - self.window)
        self.at.copy_(torch.where(begun, first, self.at))
        self.own.copy_(torch.where(begun[:, None], own, self.own))
        self.clock.copy_(torch.where(begun, first.float(), self.clock))
        self.length.copy_(torch.where(begun, self.window + spread.long(), self.length))
        self.age.copy_(torch.where(begun, 0, self.age))
        for kept, new in zip((self.eager, self.reach, self.piece, self.like, self.noise), drawn, strict=True):
            kept.copy_(torch.where(begun.reshape(-1, *(1,) * (kept.dim() - 1)), new, kept))

    def _input(self, fed: torch.Tensor, begun: torch.Tensor, chance: torch.Tensor) -> torch.Tensor:
        """The next inputs (B, 647). begun: (B, 1) rollouts that begin with the truth. chance: (B, 7)."""
        often = self.progress.truth
        truth = drift.seen(self._states(self.at), self.drift())
        keep = begun | (chance[:, 5:6] < often * self.eager) | (often >= 1)
        distance = self.frames.goal_distance(self.at, self.own)[:, None]
        planned = (self.reach < NEVER) & (
            ~self.frames.seated_goal[self.at][:, None] | (distance > self.reach)
        )
        told = begun | planned | (keep & (chance[:, 6:7] < often))
        ahead = lambda s: s[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)[:, state.NOW + 1 :, :4]
        path = torch.where(told[..., None], ahead(truth), ahead(fed))
        x = torch.where(keep, truth, fed)
        x[:, state.GOAL] = truth[:, state.GOAL]
        x[:, state.TRAJECTORY].view(-1, state.SAMPLES, 9)[:, state.NOW + 1 :, :4] = path
        return state.consistent(x)


def between(chance: torch.Tensor, low: float, high: float) -> torch.Tensor:
    """Numbers between low and high for ones between 0 and 1."""
    return low + (high - low) * chance
