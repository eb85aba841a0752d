"""Training steps of MotionNet: loss, optimiser, averaged weights; on a GPU, each step is the replay of one graph."""

from __future__ import annotations

from pathlib import Path

import torch
from torch.nn import functional

from .....models import state
from .....models.baselines import NETWORKS
from .....models.motion_net import EXTRAPOLATED_SHARE, LATENT, OBJECT, POSTURE_ROWS, POSTURES, STYLES
from .... import cuda_graph
from ..schedule import Schedule
from . import drift, earlier_run
from .frames import Frames
from .rollouts import LATEST, START_DRIFT, Draws, Rollouts

WINDOW = 60  # frames of a rollout, L of section B.3
# Weights of the loss. Predicted goals are never read, since the caller knows the goal. FUTURE is not read either, and
# FUTURE and GOAL_TRAJECTORY are partly unpredictable.
LOSS_WEIGHTS = ((state.GOAL, 0.02), (state.FUTURE, 0.3), (state.GOAL_TRAJECTORY, 0.5))
MIN_CHANGE_STD = 0.002  # smallest standard deviation of an output of the decoder
ROBUST = 1.0  # standard deviations beyond which the loss is linear in the error
BLIND = 1e4  # mean and standard deviation of what an ablation hides are multiplied by this
MIN_STD = 0.02  # smallest standard deviation of an input: nearly constant ones must not be amplified to noise
EMA_EVERY = 10
RUN_TIME_NOISE = 0.1  # standard deviation, at run time, of the components of z that are drawn every frame
UNKNOWN_SHARE = 0.1  # share of the rollouts whose style is unknown: zero, the mean person's
MAX_GRADIENT_NORM = 20.0  # the gradient is clipped to this norm
STATISTICS = 60_000  # frames from which mean and standard deviation are computed
WARM_UP = 4  # steps before the capture


class Trainer:
    """The network, its optimiser and averaged weights, and the rollouts.

    average: running average of the weights by name. sums: (3,) of pose loss, KL divergence of the components
    of z drawn every frame, and loss, since they were last read.
    """

    def __init__(self, frames: Frames, schedule: Schedule, batch: int, seed: int) -> None:
        torch.manual_seed(seed)
        frames = frames if schedule.augmented else frames.without_augmentation()
        self.frames, self.schedule, self.device = frames, schedule, frames.device
        self.net = NETWORKS[schedule.network](schedule.hidden, POSTURES).to(self.device)
        self.net.held.fill_(schedule.held)
        self.net.goal_grid.fill_(int(frames.goal_grid))
        for name, values in zip(("rows", "shares"), frames.posture_shares(POSTURE_ROWS), strict=True):
            getattr(self.net, f"posture_{name}").copy_(values)
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
        if not schedule.sees_goal_frame:
            self.weights[state.GOAL_TRAJECTORY] = 0.0
        self.sums = torch.zeros(3, device=self.device)
        self.step_number, self.summed = 0, 0
        self.graph: torch.cuda.CUDAGraph | None = None

    def _measure_statistics(self) -> None:
        """Compute mean and standard deviation of inputs, targets and object features over a sample of usable frames."""
        usable = torch.nonzero(self.frames.usable)[:, 0]
        frames = usable[torch.randperm(len(usable), device=self.device)[:STATISTICS]]
        seated = frames[self.frames.seated_goal[frames]][:6000]
        aside = (
            START_DRIFT / 2 * torch.randn(len(frames), 3, device=self.device) * float(self.schedule.drifts)
        )
        lengths = self.frames.return_lengths(frames)
        states = drift.observe(self.frames.states[frames].float(), aside, lengths)
        targets = drift.correct(self.frames.targets[frames].float(), aside, lengths)
        nowhere = torch.zeros(2, OBJECT + POSTURES, device=self.device)
        none = torch.zeros_like(seated)
        sample = {
            "input": states,
            "target": targets - EXTRAPOLATED_SHARE * state.extrapolate(states),
            "object": self.frames.object_features(seated, self.frames.roots[seated], none, none.bool())
            if len(seated)
            else nowhere,
        }
        for name, values in sample.items():
            std = values.std(0)
            floor = {"object": 1e-4, "input": MIN_STD, "target": MIN_CHANGE_STD}[name]
            std = torch.where(std < 1e-5, torch.ones_like(std), std.clamp(min=floor))
            # With these, the normalised features of all objects are nearly equal, in training and at run time.
            factor = torch.ones_like(std)
            if name == "object" and not self.schedule.sees_object:
                factor[:] = BLIND
            if name == "input" and not self.schedule.sees_goal_frame:
                factor[state.GOAL_TRAJECTORY] = BLIND
            mean, std = values.mean(0) * factor, std * factor
            if name == "object":
                mean[OBJECT:], std[OBJECT:] = 0.0, 1.0
            getattr(self.net, f"{name}_mean").copy_(mean)
            getattr(self.net, f"{name}_std").copy_(std)

    def step(self, done: float) -> None:
        """Make one optimiser step and advance all rollouts by one frame. done: share of the training, 0 to 1."""
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
        """Fuse the many small operations around the networks into few kernels. Takes up to a minute."""
        self._network_inputs = torch.compile(self._network_inputs, dynamic=False)
        self._advance_rollouts = torch.compile(self._advance_rollouts, dynamic=False)

    def capture(self) -> None:
        """Record a step as a graph, which later steps replay. CUDA only."""
        self._set_progress(0.0)
        self.graph = cuda_graph.recorded(self._advance, (self.optimiser,), WARM_UP)

    def _advance(self) -> None:
        """Compute loss, gradient, optimiser step and the next inputs, without reading any value on the host."""
        rollouts = self.rollouts
        draws = Draws.new(rollouts.count, self.device)
        with torch.no_grad():
            inputs = self._network_inputs()
        loss, out, parts = self._loss(*inputs)
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.net.parameters(), MAX_GRADIENT_NORM)
        self.optimiser.step()
        with torch.no_grad():
            self.sums += torch.stack([*parts, loss.detach()])
            self._advance_rollouts(out.detach(), draws)

    def _network_inputs(self) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return normalised states and changes (B, 647) and object features (B, 2048 + 9)."""
        rollouts, net = self.rollouts, self.net
        x, y, features = rollouts.x, rollouts.targets(), rollouts.object_features()
        return (x - net.input_mean) / net.input_std, net.change(y, x), net.normalised_object(features)

    def _advance_rollouts(self, out: torch.Tensor, draws: Draws) -> None:
        predicted = self.net.next_state(out, self.rollouts.x)
        self.rollouts.advance(predicted, self.net.target_std[state.POSE], draws)

    def _loss(
        self, x: torch.Tensor, y: torch.Tensor, features: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, tuple[torch.Tensor, ...]]:
        """Return the loss (), the outputs of the decoder (B, 647), and parts of the loss: pose, KL divergences."""
        net, schedule, count = self.net, self.schedule, self.rollouts.count
        mixed = self.device.type == "cuda" or schedule.bfloat16
        with torch.autocast(self.device.type, torch.bfloat16, enabled=mixed, cache_enabled=False):
            mean, log_variance = net.encode(x, y, features)
            z, kl = self._sample_z(mean.float(), log_variance.float())
            out = net.decoder(z, x[:count], features[:count]).float()
        error = functional.smooth_l1_loss(out, y[:count], reduction="none", beta=ROBUST) * self.weights
        loss = error.sum(-1).mean() + schedule.kl_weight * kl
        return loss, out, (error[:, state.POSE].sum(-1).mean().detach(), kl.detach())

    def _sample_z(self, mean: torch.Tensor, log_variance: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return z (B, 64) and the KL divergence () of the components that are drawn every frame.

        The held components come first: the measured style of the motion (styles.py).
        """
        count, held = self.rollouts.count, self.schedule.held
        deviation, divergence = torch.exp(0.5 * log_variance), _divergence(mean, log_variance)
        prior = self._leading(count, self.schedule.prior_share)
        noise = torch.randn(count, LATENT - held, device=self.device)
        noise = deviation[:, held:].masked_fill(prior, RUN_TIME_NOISE) * noise
        z = mean[:, held:].masked_fill(prior, 0.0) + noise
        kl = (divergence[:, held:] * ~prior).sum(-1).mean()
        if self.schedule.network != "motion_net":
            return torch.zeros(count, LATENT, device=self.device), kl
        # Counted from the other end than ``prior``, so that all combinations occur.
        unknown = self._leading(count, UNKNOWN_SHARE).flip(0)
        return torch.cat([self.rollouts.styles()[:, :held].masked_fill(unknown, 0.0), z], -1), kl

    def _leading(self, count: int, share: float) -> torch.Tensor:
        """Return flags (B, 1) of the first rollouts, up to a share of them.

        These get the noise used at run time instead of z from the encoder. With the encoder only, the decoder takes the
        phase of the gait from z; at run time, where z has no information, the legs come to rest within half a second
        while the body glides on (measured).
        """
        return (torch.arange(count, device=self.device) < share * count)[:, None]

    def losses(self) -> dict[str, float]:
        """Return the mean losses since the last call, the mean drift in metres and the share of lost rollouts."""
        sums = torch.cat([self.sums, self.rollouts.tally]) / max(self.summed, 1)
        self.sums.zero_()
        self.rollouts.tally.zero_()
        self.summed = 0
        return dict(zip(("pose", "kl", "loss", "drift", "lost"), sums.tolist(), strict=True))

    def measure_styles(self) -> None:
        """Store styles of captured motion in the network, from which held components of z are drawn at run time."""
        held = self.schedule.held
        for action in range(len(self.net.style_codes)):
            chosen, postures = self.frames.sample_styles(action, STYLES)
            if held and len(chosen):
                self.net.style_codes[action, :, :held] = chosen[:, :held]
                self.net.style_postures[action] = postures

    def exported(self) -> dict[str, torch.Tensor]:
        """Return the averaged decoder, the normalisation and the codes of styles, for models/weights.py."""
        self.measure_styles()
        buffers = {k: v for k, v in self.net.state_dict().items() if k not in self.average}
        return buffers | {k: v for k, v in self.average.items() if k.startswith("decoder.")}

    def encoder(self) -> dict[str, torch.Tensor]:
        """Return the averaged weights that only training needs."""
        return {k: v for k, v in self.average.items() if not k.startswith("decoder.")}

    def recover(self, average: dict[str, torch.Tensor]) -> None:
        """Restore averaged weights and reset the optimiser, in place, after values have become infinite."""
        with torch.no_grad():
            for name, value in self.net.named_parameters():
                value.copy_(average[name])
                self.average[name].copy_(average[name])
            for kept in self.optimiser.state.values():
                kept["exp_avg"].zero_()
                kept["exp_avg_sq"].zero_()

    def save(self, path: Path) -> None:
        """Write a checkpoint; to another file first, so that a killed process leaves no incomplete one."""
        self.measure_styles()
        body = {"net": self.net.state_dict(), "optimiser": self.optimiser.state_dict(), "average": self.average,
                "step": self.step_number}  # fmt: skip
        torch.save(body, path.with_suffix(".part"))
        path.with_suffix(".part").replace(path)

    def begin_with(self, path: Path) -> None:
        """Load averaged weights and normalisation of another run, see earlier_run.py."""
        earlier_run.load(self.net, path)
        self.average = {k: v.detach().clone() for k, v in self.net.named_parameters()}

    def resume(self, path: Path) -> None:
        """Continue from a checkpoint."""
        body = torch.load(path, map_location=self.device, weights_only=True)
        # Checkpoints of earlier versions have no codes of styles.
        own = {k: v for k, v in self.net.state_dict().items() if k.startswith("style_")}
        self.net.load_state_dict(own | body["net"])
        self.optimiser.load_state_dict(body["optimiser"])
        self.average, self.step_number = body["average"], body["step"]


def _divergence(mean: torch.Tensor, log_variance: torch.Tensor) -> torch.Tensor:
    """Return the KL divergence (B, Z) from the standard normal distribution, by component."""
    return -0.5 * (1 + log_variance - mean.square() - log_variance.exp())


def window() -> int:
    """Return the number of usable frames that must follow a start frame."""
    return WINDOW + LATEST
