"""Episodes of one room in batches, and the checks that reject the unusable ones."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from ....samp_addon import rotation
from ....samp_addon.motion import Motion
from ....samp_addon.refine.feet.foot_lock import lock_feet
from . import bodies, depth, matching
from .bank import LABELS, Bank
from .blending import Piece, joined
from .composer import LONGEST, SECONDS, EpisodeComposer, EpisodeFailed, EpisodeSteps, Request
from .matching import FPS
from .scene import DEEP, Scene
from .search import Search

AT_ONCE = 24  # episodes that are made together
MOST_TRIES = 5  # times as many episodes as wanted are tried at most
MOST_JUMP = 0.30  # metres a frame of any joint: 9 m/s
BUILDS, SLIGHT = 4, 0.1  # bodies tried for an episode; share of the last one's shape values
LOOKS = 4  # frames of a use in which the depth is looked at
INTO_USE = 5  # frames over which the foot lock fades out at the beginning of a use
UNKNOWN = 255
LEGS_TRUNK = [1, 2, 3, 4, 5, 6, 7, 8, 9]  # hips, spine, knees, ankles
_OFF_FEET = [LABELS.index(n) for n in ("sit_down", "sit", "stand_up", "lie_down", "lie", "get_up")]


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
        whole = Piece(*(getattr(whole, name)[:longest] for name in Piece.__dataclass_fields__))
    if len(whole) < SECONDS[0] * FPS:
        return "too short"
    before = deviation(bank, whole)
    dressed = _fitting_body(scene, whole, rng)
    if dressed is None:
        return "in its seat"
    build, carried, locked = dressed
    joints, _ = locked.forward_kinematics()
    if np.linalg.norm(np.diff(joints, axis=0), axis=-1).max() > MOST_JUMP:
        return "jumps"
    if (scene.depth_beside(locked.root, locked.rotations, carried.object) > DEEP).any():
        return "in something"
    rotations = rotation.continuous(locked.rotations)
    finished = Piece(
        locked.root, rotations, carried.labels, carried.feet, carried.source, carried.hands, carried.object
    )
    return Episode(finished, build, before, deviation(bank, finished))


def _fitting_body(
    scene: Scene, whole: Piece, rng: np.random.Generator
) -> tuple[bodies.Build, Piece, Motion] | None:
    """Return a random build that is not too deep in the hard furniture it uses, and the motion on it; or None.

    The last one that is tried is nearly the default human, which the uses were fitted to.
    """
    for attempt in range(BUILDS):
        build = bodies.draw(rng, 1.0 if attempt + 1 < BUILDS else SLIGHT)
        carried = bodies.carried(whole, build)
        locked = locked_feet(carried, build)
        if _depth_in_seats(scene, carried, locked, build) <= DEEP:
            return build, carried, locked
    return None


def _depth_in_seats(scene: Scene, piece: Piece, locked: Motion, build: bodies.Build) -> float:
    """Metres by which the body is in the hard furniture it uses, in some frames of each use."""
    used = np.concatenate([[-1], piece.object, [-1]])
    cuts = np.flatnonzero(np.diff(used))
    worst = 0.0
    for first, stop in zip(cuts[:-1], cuts[1:], strict=True):
        number = int(piece.object[first]) if first < len(piece) else -1
        obstacles = scene.hard(number) if number >= 0 else None
        if obstacles is None:
            continue
        frames = np.unique(np.linspace(first, stop - 1, LOOKS + 2).astype(int)[1:-1])
        worst = max(worst, depth.deepest(obstacles, locked.pose_slice(frames), build.body))
    return worst


def locked_feet(carried: Piece, build: bodies.Build) -> Motion:
    """Return the motion with locked feet, except on furniture, where the feet were fitted to the piece."""
    contacts = np.column_stack([np.zeros((len(carried), 3)), carried.feet])
    locked = lock_feet(
        Motion(carried.root, carried.rotations, contacts=contacts, rest_joints=build.body.joints)
    )
    keep = gaussian_filter1d(
        minimum_filter1d((carried.object >= 0).astype(float), 2 * INTO_USE + 1), INTO_USE / 2
    )
    root = locked.root + keep[:, None] * (carried.root - locked.root)
    rotations = rotation.slerp(locked.rotations, carried.rotations, keep[:, None])
    return replace(locked, root=root, rotations=rotations)


def deviation(bank: Bank, piece: Piece) -> np.ndarray:
    """Return how far legs and trunk (T,) uint8 are from the captured frame, see Episode."""
    source = np.maximum(piece.source, 0)
    dots = np.abs((piece.rotations[:, LEGS_TRUNK] * bank.rotations[source][:, LEGS_TRUNK]).sum(-1))
    angle = np.degrees(2 * np.arccos(np.clip(dots, 0, 1))).max(1)
    return np.where(piece.source >= 0, np.minimum(np.ceil(angle), UNKNOWN - 1), UNKNOWN).astype(np.uint8)


def contacts(piece: Piece) -> np.ndarray:
    """Contacts (T, 5) of pelvis, right and left hand, right and left foot."""
    pelvis = np.isin(piece.labels, [LABELS.index("sit"), LABELS.index("lie")]).astype(np.float32)
    return np.column_stack([pelvis, piece.hands, piece.feet])


def in_use(piece: Piece) -> np.ndarray:
    """Flags (T,) of frames on furniture."""
    return np.isin(piece.labels, _OFF_FEET)
