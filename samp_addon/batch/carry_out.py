"""One order of the batch, from its scene's file to the files that it leaves."""

from __future__ import annotations

import traceback
from dataclasses import dataclass, field
from pathlib import Path

from .. import dependencies
from ..blender.cast import baking as cast_baking
from ..blender.scene import open_scene
from ..blender.takes import baking, for_batch
from ..errors import SampError, UsageError
from ..methods.take import Take
from ..pipeline import attempts
from ..pipeline.cast.cast import Cast
from ..pipeline.cast.cast_take import CastTake
from ..pipeline.driver import Toolbox
from .console import Console, counted
from .farm import stopping
from .order import Order
from .quiet import quiet
from .results import take_files
from .resuming.saved_takes import SavedTakes


@dataclass
class Outcome:
    """What became of one order: the report's variants and errors, and the files written."""

    variants: list[dict] = field(default_factory=list)
    errors: list[dict] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)


@dataclass(frozen=True)
class Place:
    """Where an order stands in a run: `index` of `count` orders, from 0; the lines of its takes begin with label."""

    index: int = 0
    count: int = 1
    label: str = ""


def carry_out(
    made: Order,
    tools: Toolbox | None,
    console: Console,
    saved: SavedTakes | None = None,
    place: Place | None = None,
) -> Outcome:
    """Carry out one order; errors are in the outcome. place: in a jobs file."""
    place = place or Place()
    try:
        with quiet() as write:
            context, done = open_scene.open_for_job(made.scene or made.opened, made.units, made.up), []

            stopping.check()
            for path, option in ((made.npz, "--npz"), (made.dataset, "--dataset")):
                if path is not None:
                    for_batch.require_smplx(context, made.job, option)

            def on_take(take: Take | CastTake) -> None:
                done.append(take)
                text = f"{place.label}take {len(done)}/{made.job.variants}: {_line(take)}"
                console.say(text, write)
                console.advance((place.index + len(done) / made.job.variants) / place.count, text, write)

            shared = {"tools": tools, "store": saved, "on_take": on_take}
            progress = lambda stage, share: stopping.check()
            if isinstance(made.job, Cast):
                result = cast_baking.run(context, made.job, progress, **shared)
            else:
                result = baking.run(context, made.job, progress, new_character=True, **shared)
            files = take_files.write(context, made, result)
    except SampError as error:
        return Outcome(errors=[{"message": str(error)}])
    except Exception as error:
        if sentence := dependencies.explain(error):
            return Outcome(errors=[{"message": sentence}])
        # Never a traceback on the screen; whoever mends the program finds it in the report.
        text = f"Something unexpected went wrong ({type(error).__name__}: {error}); please report it."
        return Outcome(errors=[{"message": " ".join(text.split()), "traceback": traceback.format_exc()}])
    errors = [{"seed": failure.seed, "message": failure.message} for failure in result.failures]
    return Outcome(result.variants, errors, files)


def require_scene(made: Order) -> None:
    """Raise UsageError where there is no scene, before any work is done."""
    if made.scene is not None and not made.scene.is_file():
        raise UsageError(f"There is no file '{made.scene}'; name the scene to open with --scene.")
    if made.scene is None and not open_scene.is_open():
        raise UsageError("Name the scene to open with --scene FILE.")


def _line(take: Take | CastTake) -> str:
    """Return what standard output says of a finished take."""
    if isinstance(take, CastTake):
        overlap = f"bodies at most {100 * max(take.deepest, 0):.1f} cm in each other"
        return f"seed {take.seed}, {counted(len(take.takes), 'character')}, {overlap}"
    if take.goal is None:
        return f"seed {take.seed}, {take.motion.seconds:.1f} s"
    return f"seed {take.seed}, {attempts.error(take):.1f} cm from its goal"
