"""Select and weight the captured clips of several folders as one set."""

from __future__ import annotations

from pathlib import Path

from . import clip_files
from .clip_files import Clip
from .natural import styled

# Acted styles, and clips with props that are held or leaned on.
EXCLUDED = {
    "rb": (
        "drunk", "injured", "bruised", "cool", "self-assured", "angry", "extreme", "nervous", "umbrella", "trolley",
        "bag", "documents", "phone", "door", "drink", "picture", "cheer", "crouch", "work", "invite", "claphands",
    ),
    "ac": ("Box", "Crouch", "Lie", "SwingArms"),
    "o3": ("Crouching", "Jumps", "OutofRange"),
}  # fmt: skip
REST_POSE = 0.3
"""Weight of Rocketbox's standing idles and gestures, most of which return to the same two rest poses."""
CYCLES = 0.5
"""Weight of Rocketbox's walks and runs, which repeat one or two strides three times."""


def base_name(clip: Clip) -> str:
    """Return the captured clip's name, without the suffix of a mirror image."""
    return clip.name.removesuffix("_mirror")


def excluded(name: str) -> bool:
    """Return whether a clip is excluded by its name; see EXCLUDED."""
    return any(word in name for word in EXCLUDED.get(name.split("_")[0], ()))


def load(folders: list[Path]) -> list[Clip]:
    """Load the clips of all folders, without excluded ones, in the order of folders and names.

    Raise FileNotFoundError for a folder without clips.
    """
    clips = []
    for folder in folders:
        found = clip_files.load_clips(folder)
        if not found:
            raise FileNotFoundError(f"the folder '{folder}' contains no .npz clips")
        clips += [clip for clip in found if not excluded(clip.name)]
    return clips


def weight(name: str) -> float:
    """Return the sampling weight of a clip, relative to others of its kind."""
    if not name.startswith("rb_"):
        return 1.0
    if "sit" in name or "turn" in name or "start" in name or "stop" in name:
        return 1.0
    return CYCLES if "walk" in name or "run" in name else REST_POSE


def walks(clip: Clip) -> bool:
    """Return whether the locomotion and standing of a clip are natural, not acted."""
    return not styled(clip)
