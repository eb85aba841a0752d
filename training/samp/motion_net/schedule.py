"""Schedule of a training: scheduled sampling (equation 5), lengths of rollouts, learning rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....models.motion_net import HIDDEN

WARM_UP = 300  # steps in which the learning rate rises
LEAST_RATE = 0.02


@dataclass
class Schedule:
    """Options of a training. Times are shares of the training done, 0 to 1, in steps or seconds.

    P of equation 5 falls from 1 at sampling_from to least_truth. prior_share: share of rollouts with z as at run time.
    held: count of the components of z that are constant during a rollout, its style; at most 16.
    most_frames: length of the longest rollouts, reached between longer_from and longer_to. average: decay of the
    averaged weights per ten steps. drifts: rollouts keep their own place in the world and learn to return to the
    captured path (learning/drift.py). sees_goal_frame: the trajectory is also given and predicted relative to the goal.
    bfloat16: compute the networks in bfloat16 on a CPU too, as on a GPU always.
    augmented: with mirror images and with every piece of furniture that is fitted to a capture, not only the first.
    """

    rate: float
    sampling_from: float
    sampling_to: float
    least_truth: float
    kl_weight: float
    prior_share: float
    network: str = "motion_net"
    sees_object: bool = True
    hidden: int = HIDDEN
    held: int = 0
    most_frames: int = 60
    longer_from: float = 0.3
    longer_to: float = 0.6
    average: float = 0.98
    drifts: bool = True
    sees_goal_frame: bool = True
    augmented: bool = True
    bfloat16: bool = False

    def keep_truth(self, done: float) -> float:
        """Return the probability that the true state, not the prediction, is the next input."""
        falling = 1 - (done - self.sampling_from) / (self.sampling_to - self.sampling_from)
        return float(np.clip(falling, self.least_truth, 1))

    def longest(self, done: float, shortest: int) -> float:
        """Return the length of the longest rollouts, frames."""
        grown = np.clip((done - self.longer_from) / (self.longer_to - self.longer_from), 0, 1)
        return shortest + max(self.most_frames - shortest, 0) * float(grown)

    def learning_rate(self, done: float, step: int) -> float:
        """Return the learning rate: linear warm-up over WARM_UP steps, then linear decay."""
        return self.rate * min(1.0, (step + 1) / WARM_UP) * max(LEAST_RATE, 1 - done)
