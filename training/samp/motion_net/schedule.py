"""What is trained and how long: scheduled sampling (equation 5) and the learning rate over a training."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....models.motion_net import HIDDEN


@dataclass
class Schedule:
    """What is trained and how: P of equation 5 and the learning rate, over the share of training done."""

    steps: int
    rate: float
    sampling_from: float
    sampling_to: float
    least_truth: float
    kl_weight: float
    prior_share: float
    network: str = "motion_net"
    sees_object: bool = True
    hidden: int = HIDDEN

    def keep_truth(self, step: int) -> float:
        """Probability that the true state, not the prediction, is the next input."""
        done = step / self.steps
        falling = 1 - (done - self.sampling_from) / (self.sampling_to - self.sampling_from)
        return float(np.clip(falling, self.least_truth, 1))

    def learning_rate(self, step: int) -> float:
        """Linear warm-up over 300 steps, then linear decay."""
        return self.rate * min(1.0, (step + 1) / 300) * max(0.02, 1 - step / self.steps)
