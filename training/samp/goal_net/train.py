"""Train GoalNet: python -m samp_blender.training.samp.goal_net.train

The same seed on the same machine gives the same weights.
"""

from __future__ import annotations

import argparse
import pickle
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from ....models import goal_net
from ....models.weights import save_weights
from .dataset import LabelledObject, held_out_objects, training_objects
from .evaluate import COPIES, evaluate, report

BETA = (0.03, 0.06)
"""Weight of the Kullback-Leibler term, for sitting and for lying."""
TEMPERATURES = np.arange(0.4, 1.21, 0.05)
FITTED_ON = 15
"""Untrained procedural pieces of each category, to which the temperature is fitted."""
LEARNING_RATE = 1e-3
EPOCHS = 160
BATCH = 256
GOALS_AN_EPOCH = 6
"""Goals drawn for each object in each epoch."""
PRIOR_WEIGHT = 0.5
"""Weight of the error of sets of goals drawn from the prior."""
DRAWN, DRAWN_OBJECTS = 8, 48
"""Goals drawn for an object, and number of such objects in a batch."""
TURNED = 0.25
"""Share of samples with a grid turned by quarters, since fronts are inferred and some objects have none."""


@dataclass(frozen=True)
class Table:
    """Eight views of all objects: original and mirrored, each in four quarter turns.

    features: (8 N, 2048) and goals: (8, G, 6), view by view of 4 x mirrored + quarter turns. actions: (N,). labels:
    (8, N, K, 6), the goals of each object, and present: (N, K), False where an object has fewer than K.
    cumulative: (G,) number of the goal's object plus the summed weights of its goals up to this one.
    """

    features: np.ndarray
    goals: np.ndarray
    actions: np.ndarray
    labels: np.ndarray
    present: np.ndarray
    cumulative: np.ndarray

    @classmethod
    def of(cls, objects: list[LabelledObject]) -> Table:
        """Return the table of labelled objects."""
        views = [
            [seen.turned(quarters) for seen in (one, one.mirrored()) for quarters in range(4)]
            for one in objects
        ]
        most = max(len(one.goals) for one in objects)
        padded = lambda goals: np.pad(goals, ((0, most - len(goals)), (0, 0)))
        return cls(
            np.stack([view.features().astype(np.float32) for row in views for view in row]),
            np.stack([np.concatenate([row[k].goals for row in views]) for k in range(8)]).astype(np.float32),
            np.array([one.action for one in objects]),
            np.stack([[padded(row[k].goals) for row in views] for k in range(8)]).astype(np.float32),
            np.array([np.arange(most) < len(one.goals) for one in objects]),
            # The last of each object is an integer, so that rounding cannot select a goal of the next object.
            np.concatenate(
                [np.append(k + np.cumsum(one.weights[:-1]), k + 1) for k, one in enumerate(objects)]
            ),
        )

    def epoch(self, rng: np.random.Generator) -> list[tuple[torch.Tensor, ...]]:
        """Return batches of (features, action, goal, labels, present): half mirrored, goals drawn by their weights."""
        one = rng.permutation(np.repeat(np.arange(len(self.actions)), GOALS_AN_EPOCH))
        quarters = np.where(rng.random(len(one)) < TURNED, rng.integers(1, 4, len(one)), 0)
        view = 4 * rng.integers(0, 2, len(one)) + quarters
        goal = np.searchsorted(self.cumulative, one + rng.random(len(one)), side="right")
        rows = np.arange(len(one))
        return [
            tuple(
                torch.from_numpy(part)
                for part in (
                    self.features[8 * one[k] + view[k]], self.actions[one[k]], self.goals[view[k], goal[k]],
                    self.labels[view[k], one[k]], self.present[one[k]],
                )
            )
            for k in np.array_split(rows, max(1, round(len(rows) / BATCH)))
        ]  # fmt: skip


def train(
    objects: list[LabelledObject],
    seed: int,
    epochs: int = EPOCHS,
    beta: Sequence[float] = BETA,
    prior: float = PRIOR_WEIGHT,
) -> goal_net.GoalNet:
    """Return a network trained with Adam, with a learning rate that decays linearly to zero. beta: for each action.

    prior: weight of a term that is not in the paper, between sets of goals drawn from the prior and the labels. Without
    it, goals drawn between the codes of two labels are between the labels: 18 cm from either on a sofa.
    """
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    table = Table.of(objects)
    net = goal_net.GoalNet()
    weights = torch.tensor(beta)
    optimiser = torch.optim.Adam(net.parameters(), LEARNING_RATE)
    schedule = torch.optim.lr_scheduler.LambdaLR(optimiser, lambda epoch: 1 - epoch / epochs)
    for epoch in range(epochs):
        losses = []
        for features, action, goal, labels, present in table.epoch(rng):
            optimiser.zero_grad()
            value = goal_net.loss(*_arranged(net(features, action, goal), goal), weights[action])
            if prior:
                some = slice(0, DRAWN_OBJECTS)
                condition = net.condition(features[some], action[some]).repeat_interleave(DRAWN, 0)
                drawn = net.decode(condition, torch.randn(len(condition), goal_net.LATENT))
                sets = drawn.unflatten(0, (-1, DRAWN)), labels[some], present[some]
                value = value + prior * goal_net.set_error(*sets)
            value.backward()
            optimiser.step()
            losses.append(value.item())
        schedule.step()
        if epoch % 10 == 0 or epoch == epochs - 1:
            print(f"epoch {epoch:3d}  loss {np.mean(losses):.4f}", flush=True)
    return net.eval()


def fit_temperature(net: goal_net.GoalNet, objects: list[LabelledObject], seed: int) -> None:
    """Set the network's temperatures so that its goals on objects are as diverse as the labels.

    objects: not used for training, since the network's diversity is smaller on training objects.

    Informative codes leave gaps in the latent space, so goals drawn from the whole prior would be more diverse than the
    labels.
    """
    for action in range(len(goal_net.ACTIONS)):
        some = [one for one in objects if one.action == action]
        off = []
        for value in TEMPERATURES if some else ():
            net.temperature[action] = float(value)
            found = evaluate(net, some, seed)
            off.append(abs(found["apd_position_cm"] - found["apd_position_labels_cm"]))
        net.temperature[action] = float(TEMPERATURES[int(np.argmin(off))]) if off else 1.0


def _arranged(output: tuple[torch.Tensor, ...], goal: torch.Tensor) -> tuple[torch.Tensor, ...]:
    predicted, mean, log_variance = output
    return predicted, goal, mean, log_variance


def labelled(
    seed: int, copies: int, procedural: int, workers: int, cache: Path | None
) -> list[LabelledObject]:
    """Return the training objects, from the cache file if it exists."""
    if cache is not None and cache.exists():
        return pickle.loads(cache.read_bytes())
    objects = training_objects(seed, copies, procedural, workers)
    if cache is not None:
        cache.parent.mkdir(parents=True, exist_ok=True)
        cache.write_bytes(pickle.dumps(objects))
    return objects


def main() -> None:
    """Label objects, train, measure on held-out furniture, and write the weights."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--copies", type=int, default=12, help="scaled copies of each real piece")
    parser.add_argument("--procedural", type=int, default=60, help="procedural pieces of each category")
    parser.add_argument("--epochs", type=int, default=EPOCHS)
    parser.add_argument(
        "--beta", type=float, nargs=2, default=BETA, help="weights of the Kullback-Leibler term: sit, lie"
    )
    parser.add_argument(
        "--prior", type=float, default=PRIOR_WEIGHT, help="weight of the error of drawn goals"
    )
    parser.add_argument("--workers", type=int, default=1, help="processes for labelling")
    parser.add_argument("--threads", type=int, default=1, help="threads for training")
    parser.add_argument("--cache", type=Path, help="file in which labels are cached for the next run")
    parser.add_argument(
        "--folder", type=Path, help="folder of the weights (default: the shipped ones are replaced)"
    )
    parser.add_argument("--dry", action="store_true", help="measure only, without writing the weights")
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    start = time.perf_counter()
    objects = labelled(
        arguments.seed, arguments.copies, arguments.procedural, arguments.workers, arguments.cache
    )
    print(f"{len(objects)} labelled objects in {time.perf_counter() - start:.0f} s", flush=True)
    net = train(objects, arguments.seed, arguments.epochs, arguments.beta, arguments.prior)
    fresh = training_objects(arguments.seed + 1, 0, FITTED_ON, arguments.workers)
    fit_temperature(net, fresh, arguments.seed)
    print(f"temperatures {net.temperature.tolist()}")
    print(f"trained after {time.perf_counter() - start:.0f} s", flush=True)
    print(report(net, held_out_objects(seed=1, copies=COPIES)))
    if not arguments.dry:
        print(f"wrote {save_weights('goal_net', net.state_dict(), arguments.folder)}")


if __name__ == "__main__":
    main()
