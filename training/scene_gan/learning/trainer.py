"""The adversarial training: one step of critics and generators (sections 3.2, 3.3 and 4.2)."""

from __future__ import annotations

import hashlib
from pathlib import Path

import torch
from torch import nn

from ....models.scene_gan import critics as judges
from ....models.scene_gan.networks import STANDING, SceneGan
from ....models.scene_gan.projection import Motions
from ....models.scene_gan.scene_encoder import SceneEncoder
from ... import cuda_graph
from ..data.dataset import Batch, Dataset
from . import centring, losses
from .options import Options

WARM_UP = 3  # steps before the capture
STEEPEST = 10.0  # largest norm of a gradient
CLASSES = {
    "trajectory": judges.TrajectoryCritic,
    "pose": judges.PoseCritic,
    "projection": judges.ProjectionCritic,
    "context": judges.ContextCritic,
}


class Trainer:
    """Networks, critics and optimisers of one training on a data set.

    encoder: tensors of the pretrained encoder, or None. On a CPU, training is deterministic in the options' seed.
    """

    def __init__(
        self, data: Dataset, options: Options, encoder: dict[str, torch.Tensor] | None = None
    ) -> None:
        torch.manual_seed(options.seed)
        self.data, self.options = data, options
        self.random = torch.Generator().manual_seed(options.seed)
        on_gpu = data.device.type == "cuda"
        # On a GPU, random numbers are drawn there: a captured step cannot copy any from the host.
        self.draws = None if on_gpu else self.random
        self.networks = SceneGan(options.settings).to(data.device)
        if encoder is not None:
            self.networks.encoder.load_state_dict(encoder)
        self.critics = nn.ModuleDict({name: self._critic(name) for name in options.critics}).to(data.device)
        kept = options.kept if options.along else ("encoder.", *options.kept)
        trained = [p for n, p in self.networks.named_parameters() if not n.startswith(kept)]
        momentum = 0.5 if options.critics else 0.9
        adam = lambda values: torch.optim.Adam(
            values, options.rate, betas=(momentum, 0.999), fused=on_gpu or None, capturable=on_gpu
        )
        judging = list(self.critics.parameters()) or [torch.zeros(1)]  # Adam needs something
        self.generator_steps, self.critic_steps = adam(trained), adam(judging)
        self.average = {k: v.detach().clone() for k, v in self.networks.state_dict().items()}
        self.features: torch.Tensor | None = None
        self.step_number = 0
        self.graph: torch.cuda.CUDAGraph | None = None
        self._sums: dict[str, torch.Tensor] = {}
        self._averaged: list[tuple[torch.Tensor, torch.Tensor]] = []

    def _critic(self, name: str) -> nn.Module:
        sizes = self.options.settings.sizes
        return CLASSES[name](sizes, self.options.crop) if name == "context" else CLASSES[name](sizes)

    @torch.no_grad()
    def cache_features(self, folder: Path | None = None, size: int = 64) -> None:
        """Compute the scene features (2, N, scene) of all pairs, original and mirrored.

        folder: where they are cached for the next start, by encoder and data set.
        """
        path = None if folder is None else folder / f"features_{self._features_key()}.pt"
        if path is not None and path.exists():
            self.features = torch.load(path, map_location=self.data.device, weights_only=True)
            return
        self.networks.eval()
        self.networks.encoder.to(memory_format=torch.channels_last)  # faster on a CPU
        made = []
        for mirrored in (False, True):
            for first in range(0, len(self.data), size):
                pairs = torch.arange(first, min(first + size, len(self.data)), device=self.data.device)
                batch = self.data.batch(pairs, torch.full_like(pairs, mirrored, dtype=torch.bool))
                made.append(self.networks.encoder(self.data.views(self.options.settings.view, batch)).half())
        self.features = torch.cat(made).view(2, len(self.data), -1)
        self.networks.train()
        if path is not None:
            torch.save(self.features, path.with_suffix(".part"))
            path.with_suffix(".part").replace(path)

    def _features_key(self) -> str:
        """Return a hash of the encoder and the data set, on which the features depend."""
        digest = hashlib.sha256(self.data.small["pairs"].cpu().numpy().tobytes())
        for value in self.networks.encoder.state_dict().values():
            digest.update(value.cpu().numpy().tobytes())
        return digest.hexdigest()[:16]

    def keep_standing(self) -> None:
        """Store standing poses of the data set with the networks."""
        self.networks.standing.copy_(self.data.standing(STANDING))
        self.average["standing"].copy_(self.networks.standing)

    def scene(self, batch: Batch) -> torch.Tensor:
        """Return the scene features (B, scene) of a batch, cached unless the encoder is trained as well."""
        if self.options.along:
            return self.networks.encoder(self.data.views(self.options.settings.view, batch))
        if not self.options.sees_scene:
            return torch.zeros(len(batch.pairs), self.options.settings.scene, device=self.data.device)
        if self.features is None:
            self.cache_features()
        return self.features[batch.mirrored.long(), batch.pairs].float()

    def draw(self, batch: Batch, scene: torch.Tensor, count: int = 1) -> Motions:
        """Return ``count`` generated windows in a row for each one of a batch, by the trained part."""
        start, scene = batch.start.repeated(count), scene.repeat_interleave(count, 0)
        if self.options.part == "trajectory":
            made = self.networks.trajectory
            velocities = made(made.latent.draw(len(start), self.draws), scene, start)
            return Motions.moved(start, velocities)
        known = None
        if self.options.part in ("pose", "rough_pose"):
            known = batch.motions.velocities.repeat_interleave(count, 0)
        if self.options.part == "rough_pose":
            made = self.networks.pose
            return Motions.of(
                start, known, made.roughly(made.latent.draw(len(start), self.draws), start, known)
            )
        return self.networks.draw(scene, start, self.draws, known)

    def _inputs(self, name: str, motions: Motions, batch: Batch) -> torch.Tensor:
        critic = self.critics[name]
        if name == "context":
            return critic.inputs(motions, batch.start, self.data.depth(batch))
        return critic.inputs(motions, batch.start)

    def step(self) -> None:
        """Take one step of the generators after ``critic_steps`` of the critics."""
        if self.graph is None:
            self._train()
        else:
            self.graph.replay()
        self._average()
        self.step_number += 1

    def capture(self) -> None:
        """Record a step as a graph, which later steps replay. CUDA only; takes WARM_UP steps."""
        self.graph = cuda_graph.recorded(self._train, (self.critic_steps, self.generator_steps), WARM_UP)

    def _train(self) -> None:
        for _ in range(self.options.critic_steps if self.critics else 0):
            self._train_critics(self._sample())
        self._train_generators(self._sample())

    def _sample(self) -> Batch:
        return self.data.sample(self.options.batch, self.draws, self.options.moving)

    def _train_critics(self, batch: Batch) -> None:
        with torch.no_grad():
            scene = self.scene(batch)
            made = self.draw(batch, scene)
        total = torch.zeros((), device=scene.device)
        for name, critic in self.critics.items():
            real, fake = self._inputs(name, batch.motions, batch), self._inputs(name, made, batch)
            judge = lambda x, critic=critic: critic(x, scene, batch.start)
            share = torch.rand(len(real), generator=self.draws, device=scene.device)
            apart = judge(real).mean() - judge(fake).mean()
            penalty = losses.gradient_penalty(judge, real, fake, share)
            total = total - apart + losses.PENALTY * penalty
            self._note(f"{name}_distance", apart)
            self._note(f"{name}_penalty", penalty)
        self._descend(self.critic_steps, total)

    def _train_generators(self, batch: Batch) -> None:
        scene = self.scene(batch)
        draws = self.options.draws
        made = self.draw(batch, scene, max(draws, 1))
        total = torch.zeros((), device=scene.device)
        if draws:
            nearest = losses.nearest_of(made, batch.motions, draws, self.options.part, self.options.spectral)
            self._note("nearest", nearest)
            total = total + self.options.draws_weight * nearest
            made = made.rows(slice(None, None, draws))
        for name, critic in self.critics.items():
            score = critic(self._inputs(name, made, batch), scene.detach(), batch.start).mean()
            total = total - score * (self.options.context_weight if name == "context" else 1.0)
        if self.options.along and isinstance(self.networks.encoder, SceneEncoder) and self.options.depth:
            depth = self.networks.encoder.decoder(scene)[0]
            true = self.data.depth(batch)
            supervised = losses.inverse_huber(depth, true, (true < 20).float())
            self._note("depth", supervised)
            total = total + supervised
        self._note("root_error", (made.root - batch.motions.root).norm(dim=-1).mean())
        self._note("pose_error", (made.positions - batch.motions.positions).norm(dim=-1).mean())
        self._descend(self.generator_steps, total)

    def _descend(self, optimiser: torch.optim.Optimizer, loss: torch.Tensor) -> None:
        """Take a step with a gradient of limited norm; one that is not finite changes nothing and is counted."""
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        values = [p.grad for group in optimiser.param_groups for p in group["params"] if p.grad is not None]
        norm = torch.stack(torch._foreach_norm(values)).norm()
        finite = torch.isfinite(norm)
        for value in values:
            value.nan_to_num_(0.0, 0.0, 0.0)
        torch._foreach_mul_(values, torch.where(finite, (STEEPEST / norm).clamp(max=1.0), 0.0))
        self._note("dropped", 1 - finite.float())
        optimiser.step()

    @torch.no_grad()
    def _average(self) -> None:
        share = min(self.options.average, 1 - 1 / (self.step_number + 1))
        own, present = zip(*self._pairs, strict=True)
        torch._foreach_lerp_(list(own), list(present), 1 - share)

    @property
    def _pairs(self) -> list[tuple[torch.Tensor, torch.Tensor]]:
        """The averages and the present values of all weights that change."""
        if not self._averaged:
            self._averaged = [
                (self.average[name], value)
                for name, value in self.networks.state_dict().items()
                if value.is_floating_point() and (self.options.along or not name.startswith("encoder."))
            ]
        return self._averaged

    def _note(self, name: str, value: torch.Tensor) -> None:
        """Add a value to its sum, in place, because a captured step must change the same tensor."""
        both = torch.stack([value.detach(), torch.ones_like(value)])
        if name in self._sums:
            self._sums[name] += both
        else:
            self._sums[name] = both

    def losses(self) -> dict[str, float]:
        """Return the means since the last call: distance and penalty of each critic, errors, metres, against the true
        window of the same start, and the share of dropped gradients."""
        found = {name: float(total / count) for name, (total, count) in self._sums.items()}
        for both in self._sums.values():
            both.zero_()
        return found

    def averaged(self) -> SceneGan:
        """Return the networks with the averaged weights, in evaluation mode."""
        made = SceneGan(self.options.settings).to(self.data.device)
        made.load_state_dict(self.average)
        return made.eval()

    def save(self, path: Path) -> None:
        """Write the state from which training can be resumed, atomically."""
        state = {
            "networks": self.networks.state_dict(), "critics": self.critics.state_dict(), "average": self.average,
            "generator_steps": self.generator_steps.state_dict(), "critic_steps": self.critic_steps.state_dict(),
            "random": self.random.get_state(), "step": self.step_number,
        }  # fmt: skip
        part = path.with_suffix(".part")
        torch.save(state, part)
        part.replace(path)

    def begin(self, path: Path, part: str) -> None:
        """Take generators and critics from the state of another training, of a part of options.PARTS.

        Critics that only one of the trainings has are left as they are. Weights that are not trained are averaged ones.
        """
        state = torch.load(path, map_location=self.data.device, weights_only=True)
        kinds = {"all": ("trajectory.", "pose.", "joint."), "rough_pose": ("pose.rough.",)}
        generators = kinds.get(part, (f"{part}.",))
        source = lambda name: state["average" if name.startswith(self.options.kept) else "networks"]
        own = {k: source(k)[k] for k in state["networks"] if k.startswith(generators)}
        self.networks.load_state_dict(self.networks.state_dict() | own)
        for name, critic in self.critics.items():
            kept = {
                k.removeprefix(f"{name}."): v for k, v in state["critics"].items() if k.startswith(f"{name}.")
            }
            if kept:
                critic.load_state_dict(kept)
        averaged = {k: v for k, v in state["average"].items() if k in own}
        self.average, self._averaged = self.average | averaged, []

    def centre(self, count: int = 6) -> None:
        """Centre the pose generator on ``count`` batches, see centring.py, and start the average from there."""
        batches = [self._sample() for _ in range(count)]
        centring.centre(self.networks.pose, batches, [self.scene(batch) for batch in batches], self.draws)
        bias = "pose.rough.last.bias"
        self.average[bias] = self.networks.state_dict()[bias].clone()
        self._averaged = []

    def resume(self, path: Path) -> None:
        """Resume from a state written by `save`."""
        state = torch.load(path, map_location=self.data.device, weights_only=True)
        self.networks.load_state_dict(state["networks"])
        self.critics.load_state_dict(state["critics"])
        self.average, self._averaged = state["average"], []
        self.generator_steps.load_state_dict(state["generator_steps"])
        self.critic_steps.load_state_dict(state["critic_steps"])
        self.random.set_state(state["random"].cpu())
        self.step_number = state["step"]
