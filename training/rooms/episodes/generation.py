"""Episodes of one room in batches, and the checks that reject the unusable ones."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d, minimum_filter1d

from ....samp_addon import rotation
from ....samp_addon.motion import Motion
from ....samp_addon.refine.feet.foot_lock import CAPTURED, lock_feet
from . import bodies, captured, depth, matching
from .bank import LABELS, Bank
from .blending import Piece, joined
from .captured import deviation
from .composer import LONGEST, SECONDS, EpisodeComposer, EpisodeFailed, EpisodeSteps, Request
from .matching import FPS
from .scene import DEEP, FINE, STEP, Scene
from .search import Search

AT_ONCE = 24  # episodes that are made together
SHORTEST = int(SECONDS[0] * FPS)
MOST_TRIES = 9  # times as many episodes as wanted are tried at most
MOST_JUMP = 0.30  # metres a frame of any joint: 9 m/s
SLIGHT = 0.1  # share of the shape values of the last body that is tried for an episode
ROUGH = 0.008  # metres more than DEEP that are allowed before feet are locked
APPROACH = 0.03  # metres between things and the default human beyond which another body is in none
IN_THINGS = 0.0175  # metres of skin in hard things
AWAY = 4  # frames between what is kept and a frame in which the body is in something
ON_HARD = 10  # frames on hard furniture between two whose skin is looked at in the whole room
NEAR, CLOSE = 0.02, 0.01  # metres between flesh and things within which skin, and surfaces, are looked at
TOUCHED = 0.006  # metres of things in the flesh from which they are looked at twice as often
INTO_USE = 5  # frames over which the foot lock fades out at the beginning of a use


@dataclass(frozen=True)
class Episode:
    """A finished episode.

    piece: the motion on its own body. joined, deviation: (T,) degrees by which the most different joint of legs and
    trunk is turned otherwise than in the captured frame, regardless of root and heading: before inverse kinematics
    locked the feet and fitted the legs to the body, and of the finished motion. UNKNOWN where no frame was captured.
    """

    piece: Piece
    build: bodies.Build
    joined: np.ndarray
    deviation: np.ndarray


def episodes(
    bank: Bank, search: Search, scene: Scene, count: int, seed: list[int]
) -> tuple[list[Episode], Counter[str]]:
    """Return up to ``count`` episodes in a scene, and counts of the rejections by reason."""
    made: list[Episode] = []
    report: Counter[str] = Counter()
    tried = 0
    while len(made) < count and tried < MOST_TRIES * count:
        composers = [
            EpisodeComposer(bank, scene, np.random.default_rng([*seed, tried + k])) for k in range(AT_ONCE)
        ]
        rng = np.random.default_rng([*seed, tried, 1])
        tried += AT_ONCE
        for number, pieces in _played(search, scene, composers, rng, report):
            if len(made) == count:
                break
            episode = _finished(bank, scene, pieces, composers[number].rng)
            if isinstance(episode, str):
                report[episode] += 1
            else:
                made.append(episode)
                report["kept"] += 1
    return made, report


def _played(
    search: Search,
    scene: Scene,
    composers: list[EpisodeComposer],
    rng: np.random.Generator,
    report: Counter[str],
) -> list[tuple[int, list[Piece]]]:
    """Return the completed episodes with the numbers of their composers; walks are generated in batches."""
    steps = [composer.compose() for composer in composers]
    done: dict[int, list[Piece]] = {}
    waiting = {k: _step(steps[k], None, k, done, report) for k in range(len(steps))}
    while True:
        waiting = {k: request for k, request in waiting.items() if request is not None}
        if not waiting:
            return sorted(done.items())
        requests = list(waiting.values())
        walks = matching.walk(
            search, [r.route for r in requests], np.stack([r.flat for r in requests]),
            np.stack([r.pose for r in requests]), np.array([r.speed for r in requests]), rng, scene.clearance_at,
        )  # fmt: skip
        waiting = {k: _step(steps[k], walk, k, done, report) for k, walk in zip(waiting, walks, strict=True)}


def _step(
    episode: EpisodeSteps,
    walk: matching.Walk | None,
    number: int,
    done: dict[int, list[Piece]],
    report: Counter[str],
) -> Request | None:
    """Advance an episode; return its next walk request, None at its end."""
    try:
        return next(episode) if walk is None else episode.send(walk)
    except StopIteration as end:
        done[number] = end.value
    except EpisodeFailed as why:
        report[str(why)] += 1
    return None


def _finished(bank: Bank, scene: Scene, pieces: list[Piece], rng: np.random.Generator) -> Episode | str:
    """Join, carry to a body, lock the feet and check; return the episode or the reason of its rejection."""
    longest = int(LONGEST * FPS)
    whole = joined(pieces)
    if len(whole) > longest:
        whole = whole.part(0, longest)
    if len(whole) < SHORTEST:
        return "too short"
    some = np.arange(0, len(whole), STEP)
    rough = scene.depth_beside(whole.root, whole.rotations, whole.object, some, solids=False)
    clean = _longest_clean(some[rough > DEEP + ROUGH], len(whole))
    if clean is None:
        return "in something"
    whole = whole.part(*clean)
    rough = maximum_filter1d(np.maximum(rough, -1), 3)
    near = np.interp(np.arange(*clean), some, rough) > -APPROACH
    dressed = _fitting_body(bank, scene, whole, rng)
    if dressed is None:
        return "in its seat"
    build, carried = dressed
    locked = locked_feet(carried, build)
    joints, _ = locked.forward_kinematics()
    if np.linalg.norm(np.diff(joints, axis=0), axis=-1).max() > MOST_JUMP:
        return "jumps"
    clean = _longest_clean(_in_things(scene, locked, carried.object, build, near), len(whole))
    if clean is None:
        return "in something"
    finished = replace(carried, root=locked.root, rotations=rotation.continuous(locked.rotations)).part(
        *clean
    )
    before, after = (deviation(bank, p.rotations, p.source) for p in (whole.part(*clean), finished))
    return Episode(finished, build, before, after)


def _longest_clean(bad: np.ndarray, count: int) -> tuple[int, int] | None:
    """Return the longest span of frames, of ``count``, that stays away from bad ones (N,); None if all are short."""
    ends = np.concatenate([[-AWAY], np.unique(bad), [count - 1 + AWAY]])
    longest = int(np.diff(ends).argmax())
    first, stop = int(ends[longest]) + AWAY, int(ends[longest + 1]) - AWAY + 1
    return (first, stop) if stop - first >= SHORTEST else None


def _in_things(
    scene: Scene, locked: Motion, using: np.ndarray, build: bodies.Build, near: np.ndarray
) -> np.ndarray:
    """Return frames (N,) in which the body is too deep in hard things, whether it uses them (T,) or not.

    near: flags (T,) of frames in which the body may be close to things that it does not use.
    """
    frames = np.arange(0, len(locked), FINE)
    frames = frames[near[frames]]
    grazed = scene.depth_beside(locked.root, locked.rotations, using, frames, build.body.joints)
    # Seated people hardly move.
    rare = np.where(using[frames] >= 0, 4, 1)
    often, seldom = (frames % (step * rare) == 0 for step in (2 * FINE, 4 * FINE))
    used = [k for k in np.unique(using) if scene.hard(int(k)) is not None]
    on = np.flatnonzero(np.isin(using, used))[::ON_HARD]
    chosen = np.union1d(frames[(grazed > -NEAR) & often], on)
    # The body that stands outside of everything tells what is inside.
    root, turned = scene.outside
    poses = Motion(
        np.concatenate([root, locked.root[chosen]]), np.concatenate([turned, locked.rotations[chosen]]),
        rest_joints=build.body.joints,
    )  # fmt: skip
    skin = depth.skin_depth(scene.hard_things, poses, build.body)[1:]
    bad = np.union1d(frames[grazed > DEEP], chosen[skin > IN_THINGS])
    # Thin things are seen from inside the body only.
    close = np.setdiff1d(frames[(grazed > -CLOSE) & seldom | (grazed > TOUCHED) & often], bad)
    if not len(close):
        return bad
    inside = depth.near_surface_depth(scene.hard_things, locked.pose_slice(close), build.body)
    return np.union1d(bad, close[inside > IN_THINGS])


def _fitting_body(
    bank: Bank, scene: Scene, whole: Piece, rng: np.random.Generator
) -> tuple[bodies.Build, Piece] | None:
    """Return a random build that is not too deep in the hard furniture it uses, and the motion on it; or None.

    Of two that are drawn, the one whose legs are more often as captured is tried first; the last one is nearly the
    default human, which the uses were fitted to.
    """
    drawn = [bodies.draw(rng) for _ in range(2)]
    tried = [(build, bodies.carried(whole, build)) for build in drawn]
    alike = [(deviation(bank, c.rotations, c.source) <= captured.ALIKE).mean() for _, c in tried]
    first, item = int(np.argmax(alike)), -1
    for number in (first, 1 - first, -1):
        if number < 0:
            build = bodies.draw(rng, SLIGHT)
            tried.append((build, bodies.carried(whole, build)))
        deepest, item = _depth_in_seats(scene, tried[number][1], tried[number][0])
        if deepest <= depth.MOST_IN_USE:
            return tried[number]
    scene.too_deep[item] += 1
    return None


def _depth_in_seats(scene: Scene, piece: Piece, build: bodies.Build) -> tuple[float, int]:
    """Metres by which the body is in the hard furniture it uses, and the worst piece; the first one that is too deep
    ends the search."""
    used = np.concatenate([[-1], piece.object, [-1]])
    cuts = np.flatnonzero(np.diff(used))
    worst = (0.0, -1)
    for first, stop in zip(cuts[:-1], cuts[1:], strict=True):
        number = int(piece.object[first]) if first < len(piece) else -1
        obstacles = scene.hard(number)
        if obstacles is None:
            continue
        part = slice(first, stop)
        root, rotations = scene.to_piece(number, piece.root[part], piece.rotations[part])
        motion = Motion(root, rotations, rest_joints=build.body.joints)
        worst = max(worst, (depth.deepest_in_use(obstacles, motion, build.body), number))
        if worst[0] > depth.MOST_IN_USE:
            break
    return worst


def locked_feet(carried: Piece, build: bodies.Build) -> Motion:
    """Return the motion with locked feet, except on furniture, where the feet were fitted to the piece."""
    contacts = np.column_stack([np.zeros((len(carried), 3)), carried.feet])
    locked = lock_feet(
        Motion(carried.root, carried.rotations, contacts=contacts, rest_joints=build.body.joints),
        settings=CAPTURED,
    )
    keep = gaussian_filter1d(
        minimum_filter1d((carried.object >= 0).astype(float), 2 * INTO_USE + 1), INTO_USE / 2
    )
    root = locked.root + keep[:, None] * (carried.root - locked.root)
    rotations = rotation.slerp(locked.rotations, carried.rotations, keep[:, None])
    return replace(locked, root=root, rotations=rotations)


def contacts(piece: Piece) -> np.ndarray:
    """Contacts (T, 5) of pelvis, right and left hand, right and left foot."""
    pelvis = np.isin(piece.labels, [LABELS.index("sit"), LABELS.index("lie")]).astype(np.float32)
    return np.column_stack([pelvis, piece.hands, piece.feet])
