"""MotionNet's training, step by step: loss, optimiser, averaged weights; on a GPU as one replayed graph a step."""

from __future__ import annotations

from pathlib import Path

import torch
from torch.nn import functional

from .....models import state
from .....models.baselines import NETWORKS
from .....models.motion_net import EXTRAPOLATED_SHARE, LATENT
from ..schedule import Schedule
from . import drift
from .frames import Frames
from .rollouts import BEGIN_ASIDE, LATEST, Draws, Rollouts

WINDOW = 60  # frames of a rollout, L of section B.3
# Weights of the loss. The goal's numbers are never read from a prediction: the caller knows the goal. FUTURE is not
# read either, and both FUTURE and GOAL_TRAJECTORY hold what nobody can foretell.
LOSS_WEIGHTS = ((state.GOAL, 0.02), (state.FUTURE, 0.3), (state.GOAL_TRAJECTORY, 0.5))
LEAST_CHANGE = 0.002  # the same of the change that the decoder tells
ROBUST = 1.0  # standard deviations beyond which an error counts by its size, not its square
BLIND = 1e4  # by which the object's numbers are put out of sight for the ablation
LEAST_STD = 0.02  # of any input dimension: nearly constant numbers must not become loud noise
EMA_EVERY = 10
RUN_TIME_NOISE = 0.1  # standard deviation of z at run time, of what is drawn every frame
STRANGE = 0.1  # share of the rollouts whose held part of z tells nothing of what they take after
STEEPEST = 20.0  # norm of the gradient
STATISTICS = 60_000  # frames that mean and standard deviation are measured on
WARM_UP = 4  # steps before a step is captured


class Trainer:
    """The network, its optimiser and averaged weights, and the rollouts in flight.

    average: the weights' running average by name. sums: (4,) of pose loss, KL divergence of what is drawn every frame
    and of what is held, and loss, since they were last read.
    """

    def __init__(self, frames: Frames, schedule: Schedule, batch: int, seed: int) -> None:
        torch.manual_seed(seed)
        self.frames, self.schedule, self.device = frames, schedule, frames.device
        self.net = NETWORKS[schedule.network](schedule.hidden).to(self.device)
        self.net.held.fill_(schedule.held)
        self._measure_statistics()
        on_gpu = self.device.type == "cuda"
        self.rate = torch.tensor(schedule.rate, device=self.device)
        self.optimiser = torch.optim.Adam(
            self.net.parameters(), lr=self.rate if on_gpu else schedule.rate, fused=True, capturable=on_gpu
        )
        self.average = {k: v.detach().clone() for k, v in self.net.named_parameters()}
        self.rollouts = Rollouts(frames, batch, WINDOW, schedule.drifts)
        self.weights = torch.ones(state.SIZE, device=self.device)
        for part, weight in LOSS_WEIGHTS:
            self.weights[part] = weight
        self.sums = torch.zeros(4, device=self.device)
        self.step_number, self.summed = 0, 0
        self.graph: torch.cuda.CUDAGraph | None = None

    def _measure_statistics(self) -> None:
        """Mean and standard deviation of inputs, targets and object features over a sample of usable frames."""
        usable = torch.nonzero(self.frames.usable)[:, 0]
        frames = usable[torch.randperm(len(usable), device=self.device)[:STATISTICS]]
        seated = frames[self.frames.seated_goal[frames]][:6000]
        aside = (
            BEGIN_ASIDE / 2 * torch.randn(len(frames), 3, device=self.device) * float(self.schedule.drifts)
        )
        states = drift.seen(self.frames.states[frames].float(), aside)
        targets = drift.followed(self.frames.targets[frames].float(), aside)
        nowhere = torch.zeros(2, 2048, device=self.device)
        none = torch.zeros_like(seated)
        sample = {
            "input": states,
            "target": targets - EXTRAPOLATED_SHARE * state.extrapolate(states),
            "object": self.frames.object_features(seated, self.frames.roots[seated], none)
            if len(seated)
            else nowhere,
        }
        for name, values in sample.items():
            std = values.std(0)
            floor = {"object": 1e-4, "input": LEAST_STD, "target": LEAST_CHANGE}[name]
            std = torch.where(std < 1e-5, torch.ones_like(std), std.clamp(min=floor))
            # So far away and so large that every object looks the same, in training and at run time.
            blind = BLIND if name == "object" and not self.schedule.sees_object else 1.0
            getattr(self.net, f"{name}_mean").copy_(values.mean(0) * blind)
            getattr(self.net, f"{name}_std").copy_(std * blind)

    def step(self, done: float) -> None:
        """One optimiser step, all rollouts going on by one frame. done: share of the training, 0 to 1."""
        if self.step_number % EMA_EVERY == 0:
            self._set_progress(done)
        if self.graph is None:
            self._advance()
        else:
            self.graph.replay()
        self.step_number += 1
        self.summed += 1
        if self.step_number % EMA_EVERY == 0:
            self._average()

    def _set_progress(self, done: float) -> None:
        schedule, progress = self.schedule, self.rollouts.progress
        progress.truth.fill_(schedule.keep_truth(done))
        progress.longest.fill_(schedule.longest(done, WINDOW))
        rate = schedule.learning_rate(done, self.step_number)
        self.rate.fill_(rate)
        if self.device.type != "cuda":
            for group in self.optimiser.param_groups:
                group["lr"] = rate

    def _average(self) -> None:
        decay = min(self.schedule.average, 1 - 1 / (1 + self.step_number / EMA_EVERY))
        with torch.no_grad():
            torch._foreach_lerp_(list(self.average.values()), list(self.net.parameters()), 1 - decay)

    def compile(self) -> None:
        """Fuses the many small operations around the networks into few kernels. Takes up to a minute."""
        self._look = torch.compile(self._look, dynamic=False)
        self._go_on = torch.compile(self._go_on, dynamic=False)

    def capture(self) -> None:
        """Makes all later steps replays of one graph: a step is some hundred small kernels, each of which takes longer
        to launch than to run. CUDA only."""
        stream = torch.cuda.Stream()
        stream.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(stream):
            self._set_progress(0.0)
            for _ in range(WARM_UP):
                self._advance()
            self.optimiser.zero_grad(set_to_none=True)
        torch.cuda.current_stream().wait_stream(stream)
        torch.cuda.synchronize()
        graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(graph):
            self._advance()
        self.graph = graph

    def _advance(self) -> None:
        """Loss, gradient, optimiser step and the rollouts' next inputs, without a look at any value."""
        rollouts = self.rollouts
        draws = Draws.new(rollouts.count, self.device)
        with torch.no_grad():
            look = self._look()
        loss, out, parts = self._loss(*look)
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.net.parameters(), STEEPEST)
        self.optimiser.step()
        with torch.no_grad():
            self.sums += torch.stack([*parts, loss.detach()])
            self._go_on(out.detach(), draws)

    def _look(self) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """What the networks are given, normalised: states and changes (B, 647), object features (B, 2048).

        Where a part of z is held, B is twice as large: the second half is the frames that the rollouts take after.
        """
        rollouts = self.rollouts
        x, y, features = rollouts.x, rollouts.targets(), rollouts.object_features()
        if self.schedule.held:
            other = rollouts.taken_after()
            x, y, features = (torch.cat(pair) for pair in zip((x, y, features), other, strict=True))
        net = self.net
        return (x - net.input_mean) / net.input_std, net.change(y, x), net.normalised_object(features)

    def _go_on(self, out: torch.Tensor, draws: Draws) -> None:
        predicted = self.net.next_state(out, self.rollouts.x)
        self.rollouts.advance(predicted, self.net.target_std[state.POSE], draws)

    def _loss(
        self, x: torch.Tensor, y: torch.Tensor, features: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, tuple[torch.Tensor, ...]]:
        """Loss (), the decoder's outputs (B, 647), and the loss' parts: pose, KL divergences."""
        net, schedule, count = self.net, self.schedule, self.rollouts.count
        mixed = self.device.type == "cuda"
        with torch.autocast(self.device.type, torch.bfloat16, enabled=mixed, cache_enabled=False):
            mean, log_variance = net.encode(x, y, features)
            z, kl, held_kl = self._drawn(mean.float(), log_variance.float())
            out = net.decoder(z, x[:count], features[:count]).float()
        error = functional.smooth_l1_loss(out, y[:count], reduction="none", beta=ROBUST) * self.weights
        loss = error.sum(-1).mean() + schedule.kl_weight * kl + schedule.held_weight * held_kl
        return loss, out, (error[:, state.POSE].sum(-1).mean().detach(), kl.detach(), held_kl.detach())

    def _drawn(
        self, mean: torch.Tensor, log_variance: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """z (B, 64) and the KL divergences () of what is drawn every frame and of what is held.

        The first numbers of z are the encoder's at another moment of the same motion, and the same for the whole
        rollout: they can tell how somebody walks or sits, and not what comes next.
        """
        count, held = self.rollouts.count, self.schedule.held
        deviation, divergence = torch.exp(0.5 * log_variance), _divergence(mean, log_variance)
        blind = self._first(count, self.schedule.prior_share)
        noise = torch.randn(count, LATENT - held, device=self.device)
        noise = deviation[:count, held:].masked_fill(blind, RUN_TIME_NOISE) * noise
        z = mean[:count, held:].masked_fill(blind, 0.0) + noise
        kl = (divergence[:count, held:] * ~blind).sum(-1).mean()
        if self.schedule.network != "motion_net":
            return torch.zeros(count, LATENT, device=self.device), kl, torch.zeros_like(kl)
        if not held:
            return z, kl, torch.zeros_like(kl)
        # From the other end than those whose other part is noise, so that each pairing occurs.
        strange = self._first(count, STRANGE).flip(0)
        noise = self.rollouts.noise[:, :held] * deviation[count:, :held].masked_fill(strange, 1.0)
        kept = mean[count:, :held].masked_fill(strange, 0.0) + noise
        held_kl = (divergence[count:, :held] * ~strange).sum(-1).mean()
        return torch.cat([kept, z], -1), kl, held_kl

    def _first(self, count: int, share: float) -> torch.Tensor:
        """Flags (B, 1) of a share of the rollouts.

        Those get the noise of run time instead of the encoder's z. Left to the encoder alone, the decoder takes the
        phase of the gait from z; at run time, where z knows nothing, the legs then come to rest within half a second
        while the body glides on (measured).
        """
        return (torch.arange(count, device=self.device) < share * count)[:, None]

    def losses(self) -> dict[str, float]:
        """Mean losses since they were last asked for, the mean drift in metres and the share of lost rollouts."""
        sums = torch.cat([self.sums, self.rollouts.tally]) / max(self.summed, 1)
        self.sums.zero_()
        self.rollouts.tally.zero_()
        self.summed = 0
        return dict(zip(("pose", "kl", "held", "loss", "drift", "lost"), sums.tolist(), strict=True))

    def shipped(self) -> dict[str, torch.Tensor]:
        """The averaged decoder and the normalisation, as models/weights.py saves them."""
        buffers = {k: v for k, v in self.net.state_dict().items() if k not in self.average}
        return buffers | {k: v for k, v in self.average.items() if k.startswith("decoder.")}

    def encoder(self) -> dict[str, torch.Tensor]:
        """The averaged weights that only training needs."""
        return {k: v for k, v in self.average.items() if not k.startswith("decoder.")}

    def recover(self, average: dict[str, torch.Tensor]) -> None:
        """Goes back to these weights with a fresh optimiser, in place, after numbers have become infinite."""
        with torch.no_grad():
            for name, value in self.net.named_parameters():
                value.copy_(average[name])
                self.average[name].copy_(average[name])
            for kept in self.optimiser.state.values():
                kept["exp_avg"].zero_()
                kept["exp_avg_sq"].zero_()

    def save(self, path: Path) -> None:
        """A checkpoint to go on from; written beside and then moved, so that a kill never leaves half a file."""
        body = {"net": self.net.state_dict(), "optimiser": self.optimiser.state_dict(), "average": self.average,
                "step": self.step_number}  # fmt: skip
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


def _divergence(mean: torch.Tensor, log_variance: torch.Tensor) -> torch.Tensor:
    """KL divergence (B, Z) from the standard normal distribution, number by number."""
    return -0.5 * (1 + log_variance - mean.square() - log_variance.exp())


def window() -> int:
    """Frames that a rollout needs before it."""
    return WINDOW + LATEST
