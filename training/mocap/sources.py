"""Which captured clips are learnt from, and how often: several folders read as one set."""

from __future__ import annotations

from pathlib import Path

from . import clip_files
from .clip_files import Clip
from .natural import styled

# Acted styles, and objects that the captured hands hold or lean on and that no room has.
LEFT_OUT = {
    "rb": (
        "drunk", "injured", "bruised", "cool", "self-assured", "angry", "extreme", "nervous", "umbrella", "trolley",
        "bag", "documents", "phone", "door", "drink", "picture", "cheer", "crouch", "work", "invite", "claphands",
    ),
    "ac": ("Box", "Crouch", "Lie", "SwingArms"),
    "o3": ("Crouching", "Jumps", "OutofRange"),
}  # fmt: skip
REST_POSE = 0.3
"""Weight of Rocketbox's standing idles and gestures: nearly all return to the same two rest poses."""
CYCLES = 0.5
"""Weight of Rocketbox's walks and runs: the same one or two strides three times over."""


def base_name(clip: Clip) -> str:
    """The captured clip's name, mirror image or not."""
    return clip.name.removesuffix("_mirror")


def left_out(name: str) -> bool:
    """Whether a clip of the added sets is acted, or acts with an object that is missing."""
    return any(word in name for word in LEFT_OUT.get(name.split("_")[0], ()))


def load(folders: list[Path]) -> list[Clip]:
    """The clips of all folders that may be learnt from, in the order of folders and names.

    Raises FileNotFoundError for a folder without clips.
    """
    clips = []
    for folder in folders:
        found = clip_files.load_clips(folder)
        if not found:
            raise FileNotFoundError(f"{folder} holds no .npz clips")
        clips += [clip for clip in found if not left_out(clip.name)]
    return clips


def weight(name: str) -> float:
    """How often a clip's frames are drawn, relative to others of its kind."""
    if not name.startswith("rb_"):
        return 1.0
    if "sit" in name or "turn" in name or "start" in name or "stop" in name:
        return 1.0
    return CYCLES if "walk" in name or "run" in name else REST_POSE


def walks(clip: Clip) -> bool:
    """Whether the clip's locomotion and standing may be learnt from."""
    return not styled(clip)
