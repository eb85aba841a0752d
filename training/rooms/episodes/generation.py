"""Generate the episodes of one room in batches, and reject unusable ones."""

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

AT_ONCE = 24  # episodes of a batch
SHORTEST = int(SECONDS[0] * FPS)
MOST_TRIES = 9  # largest number of tries per wanted episode
MOST_JUMP = 0.30  # largest displacement (m) of a joint per frame: 9 m/s
SLIGHT = 0.1  # share of the shape values of the last body tried for an episode
ROUGH = 0.008  # additional depth (m) allowed before feet are locked
APPROACH = 0.03  # distance (m) of objects to the default human beyond which no other body touches them
IN_THINGS = 0.0175  # largest depth (m) in hard objects
AWAY = 4  # frames between kept frames and a frame with penetration
ON_HARD = 10  # stride of the frames on hard furniture whose skin is measured in the whole room
NEAR, CLOSE = (
    0.02,
    0.01,
)  # distance (m) between flesh and objects within which skin, and surfaces, are measured
TOUCHED = 0.006  # depth (m) of objects in the flesh above which they are measured twice as often
INTO_USE = 5  # frames over which the foot lock fades out at the beginning of a use


@dataclass(frozen=True)
class Episode:
    """A finished episode.

    piece: the motion on its own body. joined, deviation: (T,) largest deviation, degrees, of the rotations of legs and
    trunk from the captured frame, regardless of root and heading: before inverse kinematics locked the feet and fitted
    the legs to the body, and in the finished motion. UNKNOWN where no frame was captured.
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
    """Join the pieces, retarget to a body, lock the feet and check; return the episode or the reason of rejection."""
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
    """Return the longest span of ``count`` frames that keeps AWAY from bad ones (N,); None if all are too short."""
    ends = np.concatenate([[-AWAY], np.unique(bad), [count - 1 + AWAY]])
    longest = int(np.diff(ends).argmax())
    first, stop = int(ends[longest]) + AWAY, int(ends[longest + 1]) - AWAY + 1
    return (first, stop) if stop - first >= SHORTEST else None


def _in_things(
    scene: Scene, locked: Motion, using: np.ndarray, build: bodies.Build, near: np.ndarray
) -> np.ndarray:
    """Return the frames (N,) in which the body is too deep in hard objects, whether in use (T,) or not.

    near: (T,) flags of frames in which the body may be close to objects that it does not use.
    """
    frames = np.arange(0, len(locked), FINE)
    frames = frames[near[frames]]
    grazed = scene.depth_beside(locked.root, locked.rotations, using, frames, build.body.joints)
    # Seated bodies hardly move, so fewer frames are checked.
    rare = np.where(using[frames] >= 0, 4, 1)
    often, seldom = (frames % (step * rare) == 0 for step in (2 * FINE, 4 * FINE))
    used = [k for k in np.unique(using) if scene.hard(int(k)) is not None]
    on = np.flatnonzero(np.isin(using, used))[::ON_HARD]
    chosen = np.union1d(frames[(grazed > -NEAR) & often], on)
    # A body outside of all objects is the reference for the inside test.
    root, turned = scene.outside
    poses = Motion(
        np.concatenate([root, locked.root[chosen]]), np.concatenate([turned, locked.rotations[chosen]]),
        rest_joints=build.body.joints,
    )  # fmt: skip
    skin = depth.skin_depth(scene.hard_things, poses, build.body)[1:]
    bad = np.union1d(frames[grazed > DEEP], chosen[skin > IN_THINGS])
    # Thin objects are only detected from inside the body.
    close = np.setdiff1d(frames[(grazed > -CLOSE) & seldom | (grazed > TOUCHED) & often], bad)
    if not len(close):
        return bad
    inside = depth.near_surface_depth(scene.hard_things, locked.pose_slice(close), build.body)
    return np.union1d(bad, close[inside > IN_THINGS])


def _fitting_body(
    bank: Bank, scene: Scene, whole: Piece, rng: np.random.Generator
) -> tuple[bodies.Build, Piece] | None:
    """Return a random build that is not too deep in the hard furniture in use, and the motion on it; or None.

    Of two random builds, the one with more frames as captured is tried first; the last one is nearly the default human,
    to which the uses were fitted.
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
    """Return the depth, metres, of the body in the hard furniture in use, and the worst piece.

    The search stops at the first piece whose depth exceeds depth.MOST_IN_USE.
    """
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
    """Return the motion with locked feet, except on furniture, where feet are fitted to the piece."""
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
    """Return contacts (T, 5) of pelvis, right and left hand, right and left foot."""
    pelvis = np.isin(piece.labels, [LABELS.index("sit"), LABELS.index("lie")]).astype(np.float32)
    return np.column_stack([pelvis, piece.hands, piece.feet])
