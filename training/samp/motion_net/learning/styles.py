"""Styles of captured motion: how a body walks and rests, as a few numbers that are held for a whole take.

The encoder of the VAE sees one step, whose pose says nearly all of the next one, so the decoder ignores held components
of z that it encodes (measured: takes that differ in them alone are the same). Measured styles are not ignored, because
the poses that the network feeds itself drift towards the mean person's.
"""

from __future__ import annotations

import numpy as np
import torch

from .....models import state
from .....samp_addon.vocabulary import ACTIONS

SIZE = 16
"""Numbers of a style: the first half of the gait, the second of the rest."""

FEWEST = 20  # frames of walking or resting from which their means say something
LARGEST = 3.0  # standard deviations to which a style is clipped
_WALK, _RUN, _SIT, _LIE = (ACTIONS.index(name) for name in ("walk", "run", "sit", "lie"))


def measure(states: torch.Tensor, lengths: np.ndarray, actions: np.ndarray) -> torch.Tensor:
    """Return the styles (S, 16) of S sequences: mean 0, deviation 1, zero where a sequence neither walks nor rests.

    states: (N, 647) of all frames. lengths: (S,) frames. actions: (S,) what each sequence leads to. The gait is the
    mean and the deviation of the pose while walking or running, the rest its mean while sitting or lying, both relative
    to those of all sequences of the same kind; each is given by its first eight principal components.
    """
    gaits, rests = [], []
    for part in torch.split(states, lengths.tolist()):
        weights = part[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)[:, state.NOW, 4:]
        pose = part[:, state.POSE].float().reshape(-1, state.JOINTS, 4, 3)[:, :, :3].flatten(1)
        gaits.append(_described(pose, weights[:, [_WALK, _RUN]].sum(1) > 0.5, True))
        rests.append(_described(pose, weights[:, [_SIT, _LIE]].sum(1) > 0.5, False))
    runs, lies = (torch.as_tensor(actions == action, device=states.device) for action in (_RUN, _LIE))
    halves = [_components(torch.stack(gaits), runs), _components(torch.stack(rests), lies)]
    return torch.cat(halves, 1)


def _described(pose: torch.Tensor, during: torch.Tensor, swing: bool) -> torch.Tensor:
    """Return the mean (198,) of poses (T, 198) in some frames, with their deviation (396,) if asked for; NaN if few."""
    if int(during.sum()) < FEWEST:
        return torch.full((pose.shape[1] * (1 + swing),), torch.nan, device=pose.device)
    chosen = pose[during]
    return torch.cat([chosen.mean(0), chosen.std(0)]) if swing else chosen.mean(0)


def _components(values: torch.Tensor, other_kind: torch.Tensor) -> torch.Tensor:
    """Return the whitened principal components (S, 8) of values (S, D) relative to the mean of their kind."""
    known = values.isfinite().all(1)
    out = torch.zeros(len(values), SIZE // 2, device=values.device)
    apart = values.clone()
    for kind in (other_kind, ~other_kind):
        if (known & kind).any():
            apart[known & kind] -= values[known & kind].mean(0)
    if int(known.sum()) < 2:
        return out
    _, spread, axes = torch.linalg.svd(apart[known], full_matrices=False)
    count = min(SIZE // 2, len(spread))
    scale = spread[:count] / int(known.sum()) ** 0.5
    found = apart[known] @ axes[:count].T / scale.clamp(min=1e-4)
    out[known, :count] = found.clamp(-LARGEST, LARGEST)
    return out
