"""Takes for bodies of four shapes onto held-out seats: feet on the floor, depth in the seat.

python -m samp_blender.training.long_term.evaluation.body_shapes --weights RUN --furniture FURNITURE --seats 20

Each body stands in front of each seat, turns and sits down. The takes are those that the extension makes for a
character of that shape.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ....samp_addon.body import betas as shapes
from ....samp_addon.body import body_shape, human
from ....samp_addon.errors import SampError
from ....samp_addon.evaluation import collision, feet
from ....samp_addon.evaluation.obstacles import Obstacles
from ....samp_addon.methods.long_term import networks
from ....samp_addon.methods.long_term.method import LongTerm
from ....samp_addon.methods.method import Draw
from ....samp_addon.methods.scene_view import SceneView
from ....samp_addon.methods.step import Step
from ....samp_addon.methods.take import Take
from ....samp_addon.pipeline import other_body
from ....samp_addon.scene.geometry import SceneGeometry
from ....samp_addon.scene.seats import seats
from ....samp_addon.vocabulary import ACTIONS, SEATED
from ....tests.support import rooms
from ...evaluation.takes import held_out_seats
from ...furniture import library
from . import intervals

BODIES = {
    "1.55 m, 48 kg": {"height": 1.55, "weight": 48},
    "1.55 m, 80 kg": {"height": 1.55, "weight": 80},
    "1.95 m, 80 kg": {"height": 1.95, "weight": 80},
    "1.95 m, 120 kg": {"height": 1.95, "weight": 120},
}
FLOOR = ((-3.0, -0.1, -3.0), (3.0, 0.0, 3.0))
"""Lowest and highest corner of a box, metres."""
AWAY, ASIDE = 1.3, 0.5
"""Metres from the seat to the start of a take: forward, and to the side."""
NEAR = 2.0
"""Centimetres between the lower sole and the floor up to which a body stands on it."""


def scene(triangles: np.ndarray) -> tuple[SceneGeometry, list[tuple[np.ndarray, float]]]:
    """Return a floor with a seat (F, 3, 3), and two sub-goals: in front of it, and on it. Raises SampError."""
    geometry = SceneGeometry.from_objects([("Floor", rooms.box(*FLOOR)), ("Seat", triangles)])
    goal = seats.find_goals(triangles, "sit", 0.0, limit=1)[0]
    ahead, seat = np.asarray(goal.direction), np.asarray(goal.position)
    yaw = float(np.arctan2(ahead[0], ahead[2]))
    begin = seat + AWAY * ahead + ASIDE * np.array([ahead[2], 0.0, -ahead[0]])
    return geometry, [(begin * [1.0, 0.0, 1.0], yaw + np.pi), (seat - [0.0, 0.18, 0.0], yaw)]


def measures(take: Take, obstacles: Obstacles, body: human.Human) -> dict[str, float]:
    """Return the shares, percent, of standing frames whose lower sole is on the floor, of takes whose feet are on it in
    the end, and of frames deeper than 2 cm."""
    motion = take.motion
    lowest = np.abs(feet.sole_tracks(motion, 0.0, body)[1].min(1))
    stands = motion.actions[:, [ACTIONS.index(name) for name in SEATED]].sum(1) < 0.02
    found = collision.measures(motion, obstacles, 0.0, body)
    return {
        "standing frames with a foot on the floor": 100 * float((lowest[stands] < NEAR).mean()),
        "takes with feet on the floor in the end": 100 * float(lowest[-1] < NEAR),
        "frames deeper than 2 cm": found["penetration_2cm_percent"],
    }


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--weights", type=Path, required=True)
    parser.add_argument("--furniture", type=Path, default=library.DEFAULT_FOLDER)
    parser.add_argument("--seats", type=int, default=20)
    options = parser.parse_args(arguments)
    method = LongTerm(networks.load(options.weights))
    values: dict[str, list[tuple[float, int]]] = {}
    failed: list[str] = []
    for number, piece in enumerate(held_out_seats(library.available(options.furniture))[: options.seats]):
        try:
            geometry, goals = scene(piece.triangles)
        except SampError as error:
            failed.append(f"{piece.name}: {error}")
            continue
        obstacles = Obstacles(geometry.triangles)
        settings = {"sub_goals": tuple((*map(float, point), yaw) for point, yaw in goals)}
        step = Step(action="", method=method.name, settings=settings, hold=1.0)
        for name, asked in BODIES.items():
            made = body_shape.shapes(asked)
            view = SceneView(geometry, sub_goals=goals, betas=shapes.from_named(made))
            takes, failures = method.generate(step, view, [Draw(number, number)], lambda stage, share: None)
            failed += [f"{piece.name}, {name}: {failure.message}" for failure in failures]
            body = human.load().shaped(made)
            for take in takes:
                for measure, value in measures(other_body.fitted(take, body), obstacles, body).items():
                    values.setdefault(f"{name}, {measure}", []).append((value, number))
    for name, rows in values.items():
        print("{}: {:.1f} [{:.1f}, {:.1f}], {}".format(name, *intervals.mean(*np.array(rows).T), len(rows)))
    print("\n".join(failed))


if __name__ == "__main__":
    main()
