"""Trains MotionNet (section 3.4): rollouts with scheduled sampling, one optimiser step a frame. Resumes, logs.

python -m samp_blender.training.samp.motion_net.train --data cache/motion.npz --work RUN_FOLDER --steps 20000
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from torch.nn import functional

from ....models import state
from ....models.baselines import NETWORKS
from ....models.motion_net import EXTRAPOLATED_SHARE, HIDDEN
from . import dataset
from .schedule import Schedule

SHARES = {"sit": 0.40, "lie": 0.17, "walk": 0.19, "stroll": 0.08, "run": 0.10, "idle": 0.06}
WINDOW = 60  # frames of a rollout, L of section B.3
# Weights of the loss. The goal's numbers are never read from a prediction: the caller knows the goal. FUTURE is not
# read either, and both FUTURE and GOAL_TRAJECTORY hold what nobody can foretell.
LOSS_WEIGHTS = ((state.GOAL, 0.02), (state.FUTURE, 0.3), (state.GOAL_TRAJECTORY, 0.5))
LEAST_CHANGE = 0.002  # the same of the change that the decoder tells
ROBUST = 1.0  # standard deviations beyond which an error counts by its size, not its square
BLIND = 1e4  # by which the object's numbers are put out of sight for the ablation
LEAST_STD = 0.02  # of any input dimension: nearly constant numbers must not become loud noise
EMA = 0.98
EMA_EVERY = 10
RUN_TIME_NOISE = 0.1  # standard deviation of z at run time
# At run time the way to the seat is planned, and the last steps are the network's own. So they are in training:
# within a distance of the seat drawn from this range, and all along for a share of the rollouts.
OWN_PATH = (0.4, 1.4)  # metres
ALWAYS_OWN = 0.15
LATEST = 6  # frames that a rollout may be early or late
STAY = 0.9  # by which the frame after has to be farther off than its neighbours to be left for one of them


class Trainer:
    """The network, its optimiser and averaged weights, and the rollouts in flight."""

    def __init__(
        self, data: dataset.Dataset, schedule: Schedule, batch: int, seed: int, device: str = "cpu"
    ) -> None:
        torch.manual_seed(seed)
        self.rng = np.random.default_rng(seed)
        self.data, self.schedule, self.batch, self.device = data, schedule, batch, device
        self.net = NETWORKS[schedule.network](schedule.hidden).to(device)
        self._measure_statistics()
        self.optimiser = torch.optim.Adam(self.net.parameters(), lr=schedule.rate, fused=True)
        self.average = {k: v.detach().clone() for k, v in self.net.named_parameters()}
        starts = data.starts(WINDOW + LATEST)
        kinds = data.kinds[data.sequence[starts]]
        self.starts = {kind: starts[kinds == kind] for kind in SHARES if (kinds == kind).any()}
        self.weights = torch.ones(state.SIZE, device=device)
        for part, weight in LOSS_WEIGHTS:
            self.weights[part] = weight
        self.step_number = 0

    def _measure_statistics(self) -> None:
        """Mean and standard deviation of inputs, targets and object features over a sample of usable frames."""
        frames = np.flatnonzero(self.data.usable)
        frames = np.sort(self.rng.choice(frames, min(len(frames), 60000), replace=False))
        seated = frames[self.data.seated_goal[frames]][:: max(1, len(frames) // 6000)]
        states, targets = self._states(self.data.states, frames), self._states(self.data.targets, frames)
        sample = {
            "input": states,
            "target": targets - EXTRAPOLATED_SHARE * state.extrapolate(states),
            "object": self.data.object_features(seated) if len(seated) else torch.zeros(2, 2048),
        }
        for name, values in sample.items():
            std = values.std(0)
            floor = {"object": 1e-4, "input": LEAST_STD, "target": LEAST_CHANGE}[name]
            std = torch.where(std < 1e-5, torch.ones_like(std), std.clamp(min=floor))
            # So far away and so large that every object looks the same, in training and at run time.
            blind = BLIND if name == "object" and not self.schedule.sees_object else 1.0
            getattr(self.net, f"{name}_mean").copy_(values.mean(0) * blind)
            getattr(self.net, f"{name}_std").copy_(std * blind)

    def draw_windows(self) -> np.ndarray:
        """First frames (B,) of the next rollouts, balanced over the kinds."""
        share = np.array([SHARES[kind] for kind in self.starts])
        kinds = self.rng.choice(list(self.starts), self.batch, p=share / share.sum())
        return np.array([self.rng.choice(self.starts[kind]) for kind in kinds])

    def rollout(self) -> dict[str, float]:
        """WINDOW optimiser steps over one batch of rollouts; mean losses."""
        first = self.draw_windows()
        sums = {"pose": 0.0, "kl": 0.0, "loss": 0.0}
        # Some rollouts see the truth rarely, others often; the gait's phase of none may drift far from its target's.
        eager = self._uniform(0.4, 1.6)
        reach = torch.where(self._uniform(0, 1) < ALWAYS_OWN, 1e9, self._uniform(*OWN_PATH))
        x, at = self._states(self.data.states, first), first
        for t in range(WINDOW):
            y = self._states(self.data.targets, at)
            features = self.data.object_features(at).to(self.device)
            predicted, parts = self._step(x, y, features)
            for name in sums:
                sums[name] += parts[name] / WINDOW
            x, at = self._next_input(predicted, at + 1, first + t + 1, eager, reach)
            self.step_number += 1
        return sums

    def _next_input(
        self,
        predicted: torch.Tensor,
        at: np.ndarray,
        clock: np.ndarray,
        eager: torch.Tensor,
        reach: torch.Tensor,
    ) -> tuple[torch.Tensor, np.ndarray]:
        """Scheduled sampling (equation 5): each rollout goes on from the truth or from its own prediction (B, 647).

        at: (B,) frames that follow the ones the rollouts were at; clock: (B,) frames they would be at had none
        been early or late. eager: (B, 1) by which the probability of the truth is multiplied. reach: (B, 1) metres
        from the seat within which the future path is the prediction's even beside a true pose; farther off it is
        the planned one. Returns the inputs and the frames that they are at.
        """
        fed = state.reroot(predicted)
        at = self._aligned(fed, at, clock)
        truth = self._states(self.data.states, at)
        fed[:, state.GOAL] = truth[:, state.GOAL]
        chance = self.schedule.keep_truth(self.step_number)
        keep = self._uniform(0, 1) < (1.0 if chance >= 1 else chance * eager)
        distance = torch.as_tensor(self.data.goal_distance[at], device=self.device)[:, None]
        seat = torch.as_tensor(self.data.seated_goal[at], device=self.device)[:, None]
        planned = torch.where(reach > 1e8, False, ~seat | (distance > reach))
        told = planned | (keep & (self._uniform(0, 1) < chance))
        own, true = (s[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9) for s in (fed, truth))
        path = torch.where(told[..., None], true[:, state.NOW + 1 :, :4], own[:, state.NOW + 1 :, :4])
        x = torch.where(keep, truth, fed)
        x[:, state.TRAJECTORY].view(-1, state.SAMPLES, 9)[:, state.NOW + 1 :, :4] = path
        return state.consistent(x), at

    def _aligned(self, fed: torch.Tensor, at: np.ndarray, clock: np.ndarray) -> np.ndarray:
        """Frames (B,) near ``at`` whose true poses are nearest to the predicted ones, at most LATEST off the clock.

        A rollout whose steps come a little sooner or later than the captured ones is not wrong. Held to the clock,
        it would be taught the mean of poses in different phases: smaller and smaller steps.
        """
        best, nearest = at, None
        scale = self.net.target_std[state.POSE]
        for shift in (0, -1, 1):
            frames = np.clip(at + shift, clock - LATEST, clock + LATEST)
            frames = np.where(
                self.data.usable[frames] & (self.data.sequence[frames] == self.data.sequence[at]), frames, at
            )
            pose = self._states(self.data.states, frames)[:, state.POSE]
            distance = ((pose - fed[:, state.POSE]) / scale).square().mean(-1).cpu().numpy()
            if nearest is None:
                best, nearest = frames, distance * STAY
            else:
                closer = distance < nearest
                best, nearest = np.where(closer, frames, best), np.where(closer, distance, nearest)
        return best

    def _uniform(self, low: float, high: float) -> torch.Tensor:
        """One random number (B, 1) for each rollout."""
        return low + (high - low) * torch.rand(self.batch, 1, device=self.device)

    def _states(self, source: np.ndarray, frames: np.ndarray) -> torch.Tensor:
        return torch.as_tensor(source[frames].astype(np.float32), device=self.device)

    def _step(self, x: torch.Tensor, y: torch.Tensor, features: torch.Tensor) -> tuple[torch.Tensor, dict]:
        net = self.net
        for group in self.optimiser.param_groups:
            group["lr"] = self.schedule.learning_rate(self.step_number)
        with torch.autocast(self.device, torch.bfloat16):
            xn, yn = (x - net.input_mean) / net.input_std, net.change(y, x)
            seen = net.normalised_object(features)
            mean, log_variance = net.encode(xn, yn, seen)
            z = mean + torch.randn_like(mean) * torch.exp(0.5 * log_variance)
            blind = self._blind(len(x))
            z = torch.where(blind, RUN_TIME_NOISE * torch.randn_like(mean), z)
            z = z if self.schedule.network == "motion_net" else torch.zeros_like(z)
            out = net.decoder(z, xn, seen).float()
        error = functional.smooth_l1_loss(out, yn, reduction="none", beta=ROBUST) * self.weights
        divergence = -0.5 * (1 + log_variance - mean.square() - log_variance.exp()).float().sum(-1)
        kl = (divergence * ~blind[:, 0]).mean()
        loss = error.sum(-1).mean() + self.schedule.kl_weight * kl
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 20.0)
        self.optimiser.step()
        if self.step_number % EMA_EVERY == 0:
            with torch.no_grad():
                decay = min(EMA, 1 - 1 / (1 + self.step_number / EMA_EVERY))
                for name, value in net.named_parameters():
                    self.average[name].lerp_(value, 1 - decay)
        predicted = net.next_state(out.detach(), x)
        pose = error[:, state.POSE].sum(-1).mean()
        return predicted, {"pose": pose.item(), "kl": kl.item(), "loss": loss.item()}

    def _blind(self, count: int) -> torch.Tensor:
        """Which rollouts (B, 1) get the noise of run time instead of the encoder's z.

        Left to the encoder alone, the decoder takes the phase of the gait from z; at run time, where z knows
        nothing, the legs then come to rest within half a second while the body glides on (measured).
        """
        first = torch.arange(count, device=self.device) < self.schedule.prior_share * count
        return first[:, None]

    def save(self, path: Path) -> None:
        """A checkpoint to go on from; written beside and then moved, so that a kill never leaves half a file."""
        body = {"net": self.net.state_dict(), "optimiser": self.optimiser.state_dict(), "average": self.average,
                "step": self.step_number, "rng": self.rng.bit_generator.state}  # fmt: skip
        torch.save(body, path.with_suffix(".part"))
        path.with_suffix(".part").replace(path)

    def begin_with(self, path: Path) -> None:
        """Starts from the averaged weights of another run's checkpoint, its normalisation too."""
        body = torch.load(path, map_location=self.device, weights_only=True)
        self.net.load_state_dict({**body["net"], **body["average"]})
        self.average = {k: v.detach().clone() for k, v in self.net.named_parameters()}

    def resume(self, path: Path) -> None:
        """Goes on from a checkpoint of this program's own."""
        body = torch.load(path, map_location=self.device, weights_only=True)
        self.net.load_state_dict(body["net"])
        self.optimiser.load_state_dict(body["optimiser"])
        self.average, self.step_number = body["average"], body["step"]
        self.rng.bit_generator.state = body["rng"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument(
        "--work", type=Path, required=True, help="folder for features, checkpoints and the log"
    )
    parser.add_argument("--steps", type=int, default=20000)
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop and save after this long")
    parser.add_argument("--batch", type=int, default=512)
    parser.add_argument("--rate", type=float, default=4e-4)
    parser.add_argument(
        "--sampling", type=float, nargs=2, default=(0.1, 0.35), help="share of steps: P falls from, to"
    )
    parser.add_argument("--least-truth", type=float, default=0.3, help="P never falls below this")
    parser.add_argument("--kl", type=float, default=0.6, help="weight of the KL term")
    parser.add_argument("--prior", type=float, default=0.5, help="share of rollouts with z as at run time")
    parser.add_argument("--network", choices=NETWORKS, default="motion_net")
    parser.add_argument("--hidden", type=int, default=HIDDEN, help="width of the prediction network")
    parser.add_argument("--no-object", action="store_true", help="ablation: the object is not seen")
    parser.add_argument("--begin", type=Path, help="checkpoint of a run whose weights to begin with")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    data = dataset.load(options.data, options.work / "features")
    schedule = Schedule(
        options.steps,
        options.rate,
        *options.sampling,
        options.least_truth,
        options.kl,
        options.prior,
        options.network,
        not options.no_object,
        options.hidden,
    )
    trainer = Trainer(data, schedule, options.batch, options.seed, device)
    checkpoint = options.work / "checkpoint.pt"
    if checkpoint.exists():
        trainer.resume(checkpoint)
    elif options.begin is not None:
        trainer.begin_with(options.begin)
    began, first, saved = time.time(), trainer.step_number, time.time()
    while trainer.step_number < options.steps and time.time() - began < options.minutes * 60:
        losses = trainer.rollout()
        rate = (trainer.step_number - first) * options.batch / (time.time() - began)
        truth = schedule.keep_truth(trainer.step_number)
        text = " ".join(f"{name} {value:.2f}" for name, value in losses.items())
        line = f"step {trainer.step_number} truth {truth:.2f} {text} frames/s {rate:.0f}"
        with (options.work / "log.txt").open("a") as log:
            log.write(line + "\n")
        print(line, flush=True)
        if time.time() - saved > 300:
            trainer.save(checkpoint)
            saved = time.time()
    trainer.save(checkpoint)


if __name__ == "__main__":
    main()
