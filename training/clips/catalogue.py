"""Clips as files, and the catalogue that lists the contents of each."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...samp_addon import rotation, skeleton
from ...samp_addon.motion import Motion
from ..mocap.events import headings, label_runs
from .feet import flat_speed, lowest, soles
from .labels import LABELS, trunk_up

COLUMNS = (
    "clip", "action", "subject", "description", "seconds", "walk_s", "run_s", "idle_s", "sit_s", "lie_s", "intervals",
    "events", "frames", "glitch_frames", "slide_cm_s", "body_penetration_cm", "source", "licence",
)  # fmt: skip
STEPS = 16384  # quantisation steps per unit of stored quaternions, which then compress to two bytes


@dataclass(frozen=True, eq=False)
class ImportedClip:
    """A clip with its annotations.

    labels: (T,) names of actions. contact: (T, 4) of left heel, left ball, right heel, right ball. glitch: (T,) flags
    of pops. description: words from the file's name or from a list.
    """

    name: str
    motion: Motion
    labels: np.ndarray
    contact: np.ndarray
    glitch: np.ndarray
    subject: str = ""
    description: str = ""

    def __len__(self) -> int:
        return len(self.labels)


def save(clip: ImportedClip, folder: Path) -> Path:
    """Write folder/NAME.npz in the format that training/mocap/clip_files.py reads; return its path."""
    count = skeleton.BODY_COUNT
    path = folder / f"{clip.name}.npz"
    np.savez_compressed(
        path,
        root_pos=clip.motion.root.astype(np.float32),
        local_quat_wxyz=(
            np.round(rotation.continuous(clip.motion.rotations[:, :count]) * STEPS) / STEPS
        ).astype(np.float32),
        label=np.array([LABELS.index(label) for label in clip.labels], np.uint8),
        label_names=np.array(LABELS),
        contact=clip.contact.astype(np.uint8),
        glitch=clip.glitch.astype(np.uint8),
        rest_joints=clip.motion.rest_joints[:count].astype(np.float32),
        parents=skeleton.PARENTS[:count].astype(np.int8),
        names=np.array(skeleton.BODY_JOINTS),
        fps=int(round(clip.motion.fps)),
        source_clip=clip.name,
    )
    return path


def row(clip: ImportedClip, source: str, licence: str) -> dict[str, object]:
    """Return the clip's line of the catalogue."""
    seconds = lambda *names: round(float(np.isin(clip.labels, names).sum()) / clip.motion.fps, 1)
    runs = label_runs(clip.labels)
    at = lambda frame: round(frame / clip.motion.fps, 2)
    events = rest_events(clip)
    return {
        "clip": clip.name,
        "action": main_action(clip.labels),
        "subject": clip.subject,
        "description": clip.description,
        "seconds": at(len(clip)),
        "walk_s": seconds("walk"),
        "run_s": seconds("run"),
        "idle_s": seconds("idle", "shift"),
        "sit_s": seconds("sit"),
        "lie_s": seconds("lie"),
        "intervals": ";".join(f"{name}:{at(start)}-{at(stop)}" for name, start, stop in runs),
        "events": json.dumps(events) if events else "",
        "frames": len(clip),
        "glitch_frames": int(clip.glitch.sum()),
        "slide_cm_s": contact_slide(clip),
        "body_penetration_cm": round(float(max(-lowest(clip.motion).min(), 0.0)) * 100, 1),
        "source": source,
        "licence": licence,
    }


def main_action(labels: np.ndarray) -> str:
    """Return the main action of labels (T,): lying or sitting where at least 10 frames show it, else the commonest."""
    for action, names in (("lie", ("lie",)), ("sit", ("sit", "sit_down", "stand_up"))):
        if np.isin(labels, names).sum() >= 10:
            return action
    names, counts = np.unique(np.where(labels == "shift", "idle", labels), return_counts=True)
    return str(names[counts.argmax()])


def contact_slide(clip: ImportedClip) -> float:
    """Return the mean horizontal speed of points in contact, cm/s; 0 without contacts."""
    speed = flat_speed(soles(clip.motion), clip.motion.fps)[clip.contact > 0]
    return round(float(speed.mean()) * 100, 2) if len(speed) else 0.0


def rest_events(clip: ImportedClip) -> list[dict[str, float | None]]:
    """Return the sits and lies of a clip.

    Each has the times, seconds, at which the body begins to descend, rests, leaves and stands; the height of the
    pelvis, metres; the cosine between trunk and vertical; the heading, degrees; the distances walked before and
    after it in the clip, metres.
    """
    runs = label_runs(clip.labels)
    at = lambda frame: round(frame / clip.motion.fps, 2)
    way = np.concatenate(
        [[0.0], np.cumsum(np.linalg.norm(np.diff(clip.motion.root[:, [0, 2]], axis=0), axis=-1))]
    )
    yaw = headings(clip.motion.root, clip.motion.rotations)
    events = []
    for k, (name, start, stop) in enumerate(runs):
        if name not in ("sit", "lie"):
            continue
        goes, leaves = {"sit": ("sit_down", "stand_up"), "lie": ("lie_down", "get_up")}[name]
        down = runs[k - 1][1] if k and runs[k - 1][0] == goes else None
        up = runs[k + 1][2] if k + 1 < len(runs) and runs[k + 1][0] == leaves else None
        events.append(
            {
                "down": None if down is None else at(down),
                "seat_start": at(start),
                "seat_end": at(stop - 1),
                "up_end": None if up is None else at(up - 1),
                "pelvis_m": round(float(np.median(clip.motion.root[start:stop, 1])), 3),
                "torso_up": round(float(np.median(trunk_up(clip.motion)[start:stop])), 2),
                "yaw_deg": int(np.degrees(yaw[(start + stop) // 2]) % 360),
                "approach_m": None if down is None else round(float(way[down]), 2),
                "leave_m": None if up is None else round(float(way[-1] - way[up - 1]), 2),
            }
        )
    return events


def write_catalogue(rows: Sequence[dict[str, object]], path: Path) -> None:
    """Write the catalogue as CSV, a line for each clip."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
