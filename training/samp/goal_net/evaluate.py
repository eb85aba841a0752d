"""Evaluate GoalNet on held-out furniture: python -m samp_blender.training.samp.goal_net.evaluate"""

from __future__ import annotations

import argparse

import numpy as np
import torch

from ....models import goal_net
from ....samp_addon.evaluation import goal_samples as measures
from ....samp_addon.methods.samp.goals import draw_goals
from ....samp_addon.motion import Goal
from ....samp_addon.scene.seats import seats
from ... import furniture
from .dataset import LabelledObject, held_out_objects, real_pieces

GOALS_EACH = 10
COPIES = 4


def evaluate(net: goal_net.GoalNet, objects: list[LabelledObject], seed: int = 0) -> dict[str, float]:
    """Return the paper's measures: reconstruction errors of all goals, and diversity of N = 10 goals for each object.

    Errors are through encoder (mean of z) and decoder. Goals are drawn from the network and, as ground truth, from the
    labels by their weights.
    """
    rng, generator = np.random.default_rng(seed), torch.Generator().manual_seed(seed)
    true, rebuilt, drawn, labels = [], [], [], []
    with torch.no_grad():
        for one in objects:
            goals = torch.tensor(one.goals, dtype=torch.float32)
            condition = net.condition(
                torch.tensor(one.features(), dtype=torch.float32)[None], torch.tensor([one.action])
            )
            mean, _ = net.encode(condition.expand(len(goals), -1), goals)
            true.append(one.goals)
            rebuilt.append(net.decode(condition.expand(len(goals), -1), mean).numpy())
            z = torch.randn(GOALS_EACH, goal_net.LATENT, generator=generator)
            drawn.append(net.draw(condition.expand(GOALS_EACH, -1), z).numpy())
            labels.append(one.goals[rng.choice(len(one.goals), GOALS_EACH, p=one.weights)])
    everything, again = np.concatenate(true), np.concatenate(rebuilt)
    many, picked = np.stack(drawn), np.stack(labels)
    return {
        "objects": len(objects),
        "goals": len(everything),
        "position_error_cm": measures.position_error(again[:, :3], everything[:, :3]),
        "direction_error_deg": measures.direction_error(again[:, 3:], everything[:, 3:]),
        "apd_position_cm": measures.apd_position(many[..., :3]),
        "apd_direction_deg": measures.apd_direction(many[..., 3:]),
        "apd_position_labels_cm": measures.apd_position(picked[..., :3]),
        "apd_direction_labels_deg": measures.apd_direction(picked[..., 3:]),
        "sample_to_label_cm": nearest_label(many, objects)[0],
        "sample_to_label_deg": nearest_label(many, objects)[1],
    }


def nearest_label(drawn: np.ndarray, objects: list[LabelledObject]) -> tuple[float, float]:
    """Return the mean distance (cm) and angle (deg) from each drawn goal (L, N, 6) to its closest label.

    For the choice of the closest label, 10 cm count as much as 15 degrees.
    """
    gaps, turns = [], []
    for goals, one in zip(drawn, objects, strict=True):
        gap = np.linalg.norm(goals[:, None, :3] - one.goals[None, :, :3], axis=-1)
        unit = goals[:, 3:] / np.linalg.norm(goals[:, 3:], axis=1, keepdims=True)
        turn = np.degrees(np.arccos(np.clip(unit @ one.goals[:, 3:].T, -1, 1)))
        best = (gap / 0.10 + turn / 15).argmin(axis=1)
        rows = np.arange(len(goals))
        gaps.append(gap[rows, best])
        turns.append(turn[rows, best])
    return float(100 * np.mean(gaps)), float(np.mean(turns))


def handed_out(pieces: list[furniture.Piece], action: str, seed: int = 0) -> dict[str, float]:
    """Return the diversity of the shipped network's goals on the real surface, and of labels drawn by their weights.

    N = 10 for each piece; pieces without a place for the action are left out.
    """
    rng = np.random.default_rng(seed)
    given, labels = [], []
    for piece in pieces:
        found = seats.seats_on_map(seats.support_map(piece.triangles), action, seats.MANY_SEATS)
        if not found:
            continue
        weights = np.array([seat.score for seat in found])
        drawn = rng.choice(len(found), GOALS_EACH, p=weights / weights.sum())
        labels.append([_row(found[k].goal) for k in drawn])
        given.append([_row(goal) for goal in draw_goals(piece.triangles, action, GOALS_EACH, seed).goals])
    ours, theirs = np.array(given), np.array(labels)
    return {
        "objects": len(ours),
        "apd_position_cm": measures.apd_position(ours[..., :3]),
        "apd_position_labels_cm": measures.apd_position(theirs[..., :3]),
        "apd_direction_deg": measures.apd_direction(ours[..., 3:]),
        "apd_direction_labels_deg": measures.apd_direction(theirs[..., 3:]),
    }


def _row(goal: Goal) -> np.ndarray:
    return np.concatenate([goal.position, goal.direction])


def report(net: goal_net.GoalNet, objects: list[LabelledObject]) -> str:
    """Return a table of the measures, with a column for each action."""
    return _columns(
        {
            action: evaluate(net, [one for one in objects if one.action == index])
            for index, action in enumerate(goal_net.ACTIONS)
        }
    )


def _columns(columns: dict[str, dict[str, float]]) -> str:
    lines = [f"{'':28}" + "".join(f"{action:>10}" for action in columns)]
    for key in next(iter(columns.values())):
        lines.append(f"{key:28}" + "".join(f"{column[key]:10.2f}" for column in columns.values()))
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--copies", type=int, default=COPIES, help="scaled copies of each held-out piece")
    arguments = parser.parse_args()
    print(furniture.missing() or "All held-out pieces.")
    print(report(goal_net.load(), held_out_objects(seed=1, copies=arguments.copies)))
    print("on the real surface, as in the extension:")
    print(_columns({action: handed_out(real_pieces(held_out=True), action) for action in goal_net.ACTIONS}))
