"""What is asked for: one job, from a command line, a line of a jobs file or an operator.

Blender's world here, as the artist sees it: metres, Z up; yaw in degrees, 0 faces -Y, positive turns left.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, NoReturn

from ..errors import SampError
from ..motion import ACTIONS

METHODS = ("samp", "long_term", "scene_gan")
READY_METHODS = ("samp",)
SEATED = ("sit", "lie")
MOST_VARIANTS = 1000
SLOWEST, FASTEST = 0.5, 2.0
STEP = ("action", "target", "to")


class UsageError(SampError):
    """Arguments that cannot be used, whatever the scene holds."""


@dataclass(frozen=True)
class Job:
    """Takes of one action in one scene.

    target: name of an object, empty or collection. to: place (x, y, z) or (x, y, z, yaw) to walk to.
    character: name of an SMPL-X armature; empty: the caller's choice. start: (x, y, z, yaw) or None for where
    the character stands, or a free place. seed: of the first take; variants: how many. refine: whether contact,
    penetration and foot slide of each take are mended. hold: seconds at the end. style: how much each take differs
    from the most common one (SAMP draws with 0.1). speed: of the motion beside that of the captured people. via:
    places (x, y, z) that the way to the first goal passes in their order. then: what follows in the same takes; of
    these jobs only action, target and to count.
    """

    action: str = "sit"
    target: str = ""
    to: tuple[float, ...] | None = None
    character: str = ""
    start: tuple[float, float, float, float] | None = None
    seed: int = 0
    variants: int = 1
    refine: bool = False
    method: str = "samp"
    hold: float = 2.0
    style: float = 0.1
    speed: float = 1.0
    via: tuple[tuple[float, float, float], ...] = ()
    then: tuple[Job, ...] = ()

    def __post_init__(self) -> None:
        self._check_choices()
        self._check_places()

    @property
    def seeds(self) -> range:
        """The takes' seeds, from `seed` upward."""
        return range(self.seed, self.seed + self.variants)

    @property
    def steps(self) -> tuple[Job, ...]:
        """The single actions, in their order, each a job of its own."""
        shared = ("seed", "variants", "hold", "method", "style", "speed")
        own = {name: getattr(self, name) for name in shared}
        return (replace(self, then=()), *(replace(job, **own, then=()) for job in self.then))

    def _check_choices(self) -> None:
        if self.action not in ACTIONS:
            raise UsageError(f"There is no action '{self.action}'; choose one of {', '.join(ACTIONS)}.")
        if self.method not in METHODS:
            raise UsageError(f"There is no method '{self.method}'; choose one of {', '.join(METHODS)}.")
        if self.method not in READY_METHODS:
            raise UsageError(f"The method '{self.method}' is not in this version yet; choose samp.")
        if not 1 <= self.variants <= MOST_VARIANTS:
            raise UsageError(f"--variants is {self.variants}; choose from 1 to {MOST_VARIANTS}.")
        if not 0 <= self.seed < 2**31:
            raise UsageError(f"--seed is {self.seed}; choose from 0 to {2**31 - 1}.")
        if not 0 <= self.hold <= 3600:
            raise UsageError(f"--hold is {self.hold}; choose from 0 to 3600 seconds.")
        if not 0 <= self.style <= 1:
            raise UsageError(f"--style is {self.style}; choose from 0 to 1.")
        if not SLOWEST <= self.speed <= FASTEST:
            raise UsageError(f"--speed is {self.speed}; choose from {SLOWEST} to {FASTEST}.")

    def _check_places(self) -> None:
        if self.action in SEATED and not self.target:
            raise UsageError(f"Name what to {self.action} on with --target.")
        if self.action in ("walk", "run") and not self.target and self.to is None:
            raise UsageError(f"Say where to {self.action} with --to X Y Z [YAW] or --target.")
        if self.action in SEATED and self.to is not None:
            raise UsageError(f"--to is for walk and run; to {self.action}, name a --target.")
        for name, place, lengths in (("to", self.to, (3, 4)), ("start", self.start, (4,))):
            if place is not None and (len(place) not in lengths or not all(map(math.isfinite, place))):
                needed = "X Y Z [YAW]" if len(lengths) > 1 else "X Y Z YAW"
                raise UsageError(f"--{name} needs the numbers {needed}.")
        if not all(len(place) == 3 and all(map(math.isfinite, place)) for place in self.via):
            raise UsageError("--via needs the numbers X Y Z of each place.")


@dataclass(frozen=True)
class Order:
    """A job of the batch: what to make, from which file, and what to write. Paths are as the user gave them."""

    job: Job
    scene: Path | None = None
    output: Path | None = None
    npz: Path | None = None
    report: Path | None = None

    def options(self) -> dict[str, Any]:
        """The options in force, as JSON holds them; paths absolute."""
        told = {f.name: getattr(self.job, f.name) for f in fields(Job)}
        told["then"] = [{name: getattr(job, name) for name in STEP} for job in self.job.then]
        for name in ("scene", "output", "npz"):
            path = getattr(self, name)
            told[name] = None if path is None else str(path.absolute())
        return json.loads(json.dumps(told))


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise UsageError(message[:1].upper() + message[1:] + ".")


def parser() -> argparse.ArgumentParser:
    """The options of the batch. Its errors are UsageErrors; its defaults are left out of the result."""
    made = _Parser(
        prog="bake.py",
        description="Bakes takes: a character walks to the furniture and sits down, as keyframes.",
        argument_default=argparse.SUPPRESS,
        allow_abbrev=False,
    )
    add = made.add_argument
    add("--scene", metavar="FILE", help=".blend, .glb, .gltf, .obj, .fbx or .usd; left out, the open file")
    add("--action", metavar="ACTION", help=", ".join(ACTIONS) + "; several in a row with commas between them")
    add(
        "--target",
        metavar="NAME",
        help="object, or empty or collection that holds the furniture's parts; "
        "for several actions one each, with commas between them",
    )
    add("--to", type=float, nargs="+", metavar="N", help="X Y Z [YAW]: where to walk or run, metres, degrees")
    add("--character", metavar="NAME", help="an SMPL-X armature; left out, the default human is made")
    add("--start", type=float, nargs="+", metavar="N", help="X Y Z YAW: metres and degrees; yaw 0 faces -Y")
    add("--seed", type=int, metavar="N", help="seed of the first take (0)")
    add("--variants", type=int, metavar="K", help="number of takes, with seeds from N upward (1)")
    add("--hold", type=float, metavar="SECONDS", help="how long the action is held at the end (2)")
    add("--style", type=float, metavar="S", help="how much takes differ, 0 to 1 (0.1)")
    add("--speed", type=float, metavar="F", help="of the motion beside people's own, 0.5 to 2 (1)")
    add("--via", type=float, nargs="+", metavar="N", help="X Y Z [X Y Z ...]: places that the way passes")
    add("--refine", action="store_true", help="run the optimisation on each take")
    add("--method", metavar="METHOD", help="samp (default), long_term, scene_gan")
    add("--output", metavar="FILE", help=".blend with one Action for each take, the first one active")
    add("--npz", metavar="DIR", help="folder for each take as AMASS SMPL-X .npz")
    add("--report", metavar="FILE", help="JSON about what was made")
    add(
        "--jobs",
        metavar="FILE",
        help="many jobs: a JSON object of these options a line; done ones are skipped",
    )
    return made


def parse(arguments: Sequence[str]) -> dict[str, Any]:
    """The options on a command line, without those left out. Raises UsageError."""
    return vars(parser().parse_args(list(arguments)))


def order(options: Mapping[str, Any]) -> Order:
    """One order from options by their names without dashes. Raises UsageError for unknown or unusable ones."""
    known = {f.name: f.type for f in fields(Job) if f.name != "then"} | dict.fromkeys(
        ("scene", "output", "npz", "report"), "path"
    )
    unknown = sorted(set(options) - set(known))
    if unknown:
        raise UsageError(f"There is no option '{unknown[0]}'; use {', '.join(sorted(known))}.")
    steps = _steps({name: options[name] for name in STEP if options.get(name) is not None})
    values = {
        name: _typed(name, known[name], value)
        for name, value in (options | steps[0]).items()
        if value is not None and name not in set(STEP) - set(steps[0])
    }
    if "action" not in values:
        raise UsageError("Say what to do with --action: " + ", ".join(ACTIONS) + ".")
    then = tuple(
        Job(**{name: _typed(name, known[name], value) for name, value in step.items()}) for step in steps[1:]
    )
    job = Job(**{name: value for name, value in values.items() if known[name] != "path"}, then=then)
    made = Order(job, **{name: value for name, value in values.items() if known[name] == "path"})
    if made.output is None and made.npz is None and made.report is None:
        raise UsageError("Say where the result goes with --output, --npz or --report.")
    if made.output is not None and made.output.suffix != ".blend":
        raise UsageError(f"--output is '{made.output}'; name a .blend file.")
    return made


def _steps(told: dict[str, Any]) -> list[dict[str, Any]]:
    """The options of each step. Lists, or text with commas, tell several; one --to belongs to the only walk that
    has no target. Raises UsageError."""
    action = told.get("action")
    several = isinstance(action, list) or (isinstance(action, str) and "," in action)
    if not several:
        return [told]
    split = (
        lambda value: [part.strip() for part in value.split(",")] if isinstance(value, str) else list(value)
    )
    actions, targets, to = split(action), split(told.get("target", [])), told.get("to")
    if len(targets) > len(actions):
        raise UsageError(f"There are {len(targets)} targets for {len(actions)} actions; name one for each.")
    targets += [""] * (len(actions) - len(targets))
    steps = [{"action": a, "target": t} for a, t in zip(actions, targets, strict=True)]
    if to is not None:
        ways = [step for step in steps if step["action"] in ("walk", "run") and not step["target"]]
        places = to if isinstance(to[0], list | tuple) else [to]
        if len(ways) != len(places):
            raise UsageError(f"There are {len(places)} places --to for {len(ways)} walks without a target.")
        for step, place in zip(ways, places, strict=True):
            step["to"] = place
    return steps


def _typed(name: str, kind: str, value: object) -> object:
    """A value from JSON or the command line as its option needs it."""
    if kind == "path":
        if isinstance(value, str) and value:
            return Path(value)
        raise UsageError(f"--{name} needs the name of a file.")
    if kind in ("bool", "str") and type(value).__name__ == kind:
        return value
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if kind == "int" and number and value == int(value):
        return int(value)
    if kind == "float" and number:
        return float(value)
    if kind.startswith("tuple") and isinstance(value, list | tuple):
        try:
            if kind.startswith("tuple[tuple"):
                return _triples(value)
            return tuple(float(v) for v in value)
        except (TypeError, ValueError):
            pass
    raise UsageError(f"--{name} cannot be {json.dumps(value)}.")


def _triples(values: Sequence) -> tuple[tuple[float, ...], ...]:
    """Places of a flat list of numbers, or of a list of places. The last one is short where numbers are missing."""
    flat = [float(v) for part in values for v in (part if isinstance(part, list | tuple) else [part])]
    return tuple(tuple(flat[k : k + 3]) for k in range(0, len(flat), 3))


def with_seed(job: Job, seed: int) -> Job:
    """The job for one take."""
    return replace(job, seed=seed, variants=1)
