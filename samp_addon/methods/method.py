"""What a method is: a way to make motion for one step of a job in a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol

from ..errors import UsageError
from ..vocabulary import SEATED

if TYPE_CHECKING:
    from ..progress import Progress
    from .scene_view import SceneView
    from .step import Step
    from .take import Failure, Take


@dataclass(frozen=True)
class Option:
    """An option of one method only; the command line, jobs files and the panel all offer it.

    name: as in a jobs file; on the command line ``--`` is put before it and dashes stand for underscores. kind: float,
    int or str. metavar: one name for each value of an occurrence. repeated: whether it may occur several times; its
    value is then a tuple of occurrences. default: the value where it is left out. minimum, maximum: bounds of numbers.
    switch: on the command line, where it differs from the name. choices: words that a text is made of, with commas
    between several; the panel offers each. for_actions: those words that belong to some actions alone, by action.
    """

    name: str
    help: str
    kind: type = float
    metavar: tuple[str, ...] = ("N",)
    repeated: bool = False
    default: Any = None
    minimum: float | None = None
    maximum: float | None = None
    switch: str = ""
    choices: tuple[str, ...] = ()
    for_actions: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: MappingProxyType({}))

    def words(self, action: str) -> tuple[str, ...]:
        """Return the choices for an action."""
        return self.for_actions.get(action, ()) if self.for_actions else self.choices

    @property
    def flag(self) -> str:
        """The option on the command line."""
        return self.switch or "--" + self.name.replace("_", "-")


@dataclass(frozen=True)
class Draw:
    """One take that a method is asked for.

    seed: the take's, as the artist counts them. noise: the seed of everything random in it; another one than `seed`
    when the driver tries the take again.
    """

    seed: int
    noise: int


class Method(Protocol):
    """A way to make motion.

    name: the value of ``--method`` and of the report. label, description: in the panel. actions: those it can be asked
    for; empty where it takes none. needs: fields of SceneView that have to be filled; "others" is filled by the
    pipeline, which then generates the members of a cast one after another. options: its own options. batch_size: how
    many takes one call of `generate` may make.
    """

    name: str
    label: str
    description: str
    actions: tuple[str, ...]
    needs: frozenset[str]
    options: tuple[Option, ...]
    batch_size: int

    def check(self, step: Step) -> None:
        """Raise UsageError for a step that this method cannot make in any scene."""

    def generate(
        self, step: Step, scene: SceneView, draws: Sequence[Draw], progress: Progress
    ) -> tuple[list[Take], list[Failure]]:
        """Return a take for each draw, and the reasons of those that failed, both by the draw's seed.

        A method makes one attempt; the driver decides about another one. A draw whose seed is in `scene.after`
        begins where that take ends. The work may run in a thread; what `progress` raises stops it.
        """

    def installed(self) -> bool:
        """Return whether the method's weights are there; a method without them is not offered."""

    def load(self) -> None:
        """Load the networks, so that the first `generate` is as fast as the next one."""


def checked_settings(method: Method, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a method's own options, defaults filled in. Raise UsageError for others."""
    known = {option.name: option for option in method.options}
    unknown = sorted(set(settings) - set(known))
    if unknown:
        raise UsageError(f"The method '{method.name}' has no option '{unknown[0]}'; leave it out.")
    for name, value in settings.items():
        _check_bounds(known[name], value)
    return {name: settings.get(name, option.default) for name, option in known.items()}


def _check_bounds(option: Option, value: object) -> None:
    if option.kind is str or option.repeated or value is None:
        return
    low, high = option.minimum, option.maximum
    for number in value if isinstance(value, tuple) else (value,):
        inside = (low is None or number >= low) and (high is None or number <= high)
        if not inside:
            limits = " ".join(
                f"{word} {limit:g}" for word, limit in (("from", low), ("to", high)) if limit is not None
            )
            raise UsageError(f"{option.flag} is {number:g}; choose {limits}.")


def require_place(step: Step) -> None:
    """Raise UsageError where an action that needs a target or a place has none."""
    if step.action in SEATED and not step.target:
        raise UsageError(f"Name what to {step.action} on with --target.")
    if step.action in ("walk", "run") and not step.target and step.to is None:
        raise UsageError(f"Say where to {step.action} with --to X Y Z [YAW] or --target.")
