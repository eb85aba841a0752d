"""A guess at which bone of an unknown humanoid is which joint: by words in bone names, else by hierarchy and place.

The artist corrects it in the bone table.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from . import maps
from .unknown.by_place import by_place
from .unknown.tree import Tree, spine_joints

# Words in the names of each part, the most certain first; each is a run of letters without gaps.
WORDS = {
    "hip": ("upleg", "upperleg", "legupper", "thigh", "femur", "hip"),
    "knee": ("lowerleg", "lowleg", "leglower", "calf", "shin", "knee", "tibia", "leg"),
    "ankle": ("ankle", "foot"),
    "foot": ("toebase", "toes", "toe", "ball"),
    "collar": ("clavicle", "collar", "shoulder"),
    "shoulder": ("upperarm", "uparm", "armupper", "humerus", "shldr", "shoulder", "arm"),
    "elbow": ("forearm", "lowerarm", "lowarm", "armlower", "elbow"),
    "wrist": ("wrist", "hand"),
    "pelvis": ("pelvis", "hips", "hip", "cog"),
    "spine": ("spine", "abdomen", "waist", "upperchest", "chest", "torso"),
    "neck": ("neck",),
    "head": ("head",),
    "index": ("index", "pointer"),
    "middle": ("middle", "mid"),
    "ring": ("ring",),
    "pinky": ("pinky", "little", "small"),
    "thumb": ("thumb",),
}
# Words in the names of bones that are attached to a limb but are none of its joints.
HELPERS = (
    "twist", "roll", "ik", "pole", "target", "end", "nub", "tip", "helper", "mch", "metacarpal", "palm", "ctrl",
    "control", "socket", "jiggle", "corrective", "share", "muscle", "weapon", "prop", "eye", "jaw",
)  # fmt: skip
_LEFT, _RIGHT = ("l", "left", "lft"), ("r", "right", "rgt")
_LIMBS = (("hip", "knee", "ankle", "foot"), ("collar", "shoulder", "elbow", "wrist"))


def guess(names: Sequence[str], parents: Sequence[int], heads: np.ndarray) -> dict[str, str]:
    """Return joint -> bone name, without the joints for which there is no guess.

    names, parents: (B,) of the bones; heads: (B, 3). A gap in a limb is filled by the bone that lies in it. Where the
    names leave out an essential joint, hierarchy and place decide.
    """
    tree = Tree(parents)
    chosen = _by_name(names, tree)
    if any(joint not in chosen for joint in maps.ESSENTIAL):
        placed = by_place(np.asarray(heads, dtype=np.float64), tree)
        chosen = placed if len(placed) > len(chosen) else chosen
    return {joint: names[chosen[joint]] for joint in maps.JOINTS if joint in chosen}


def _by_name(names: Sequence[str], tree: Tree) -> dict[str, int]:
    """Return joint -> bone by the words in the names."""
    words = [_words(name) for name in names]
    sides = _sides(words, tree)
    chosen: dict[str, int] = {}
    for side in ("left", "right"):
        free = [bone for bone in range(len(names)) if sides[bone] == side and not _is_helper(words[bone])]
        for limb in _LIMBS:
            chosen |= {f"{side}_{part}": bone for part, bone in _limb(limb, free, words, tree).items()}
        chosen |= _fingers(side, free, words, tree, chosen.get(f"{side}_wrist"))
    middle = [bone for bone in range(len(names)) if sides[bone] is None and not _is_helper(words[bone])]
    return chosen | _trunk(middle, words, tree, chosen)


def _words(name: str) -> list[str]:
    """Split a bone name into lower-case words at signs, digits and capitals; a namespace before a colon is dropped."""
    stem = name.rsplit(":", 1)[-1]
    stem = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", stem)
    return [word.lower() for word in re.findall(r"[A-Za-z]+|\d+", stem)]


def _sides(words: list[list[str]], tree: Tree) -> list[str | None]:
    """Return the side of each bone (B,), by its own name or else by that of its parent."""
    result: list[str | None] = [None] * len(words)
    for bone in sorted(range(len(words)), key=lambda bone: tree.depth[bone]):
        marks = [word for word in words[bone] if word in _LEFT + _RIGHT]
        joined = [word for word in words[bone] if word.startswith(("left", "right"))]
        if marks or joined:
            result[bone] = "left" if (marks or joined)[0][0] == "l" else "right"
        elif tree.parents[bone] >= 0:
            result[bone] = result[tree.parents[bone]]
    return result


def _is_helper(words: list[str]) -> bool:
    """Return whether a name is that of a helper bone; some rigs call the neck a twist bone."""
    return any(word in HELPERS for word in words) and "neck" not in words


def _score(words: list[str], part: str) -> float:
    """Return how certainly a name means a part; 0 if it does not."""
    text = "".join(word for word in words if word not in _LEFT + _RIGHT and not word.isdigit())
    text = re.sub(r"^(left|right)|(left|right)$", "", text)
    for rank, word in enumerate(WORDS[part]):
        if text == word:
            return 2.0 - 0.05 * rank
        if word in text:
            return 1.0 - 0.05 * rank
    return 0.0


def _limb(parts: Sequence[str], free: Sequence[int], words: list[list[str]], tree: Tree) -> dict[str, int]:
    """Return part -> bone for the descending sequence of bones whose names fit the parts of a limb best."""
    best: dict[int, list[tuple[float, dict[str, int]]]] = {}
    order = sorted(free, key=lambda bone: tree.depth[bone])
    result: tuple[float, dict[str, int]] = (0.0, {})
    for bone in order:
        # The best assignments of a part to this bone, and of earlier parts to bones above it.
        above = [found for upper in tree.above(bone) for found in best.get(upper, [])]
        options = []
        for k, part in enumerate(parts):
            score = _score(words[bone], part)
            if score <= 0:
                continue
            before = [found for found in above if all(parts.index(used) < k for used in found[1])]
            total, used = max(before, key=lambda found: found[0], default=(0.0, {}))
            options.append((total + score - 0.001 * tree.depth[bone], used | {part: bone}))
        best[bone] = options
        result = max([result, *options], key=lambda found: found[0])
    return _fill_gaps(parts, dict(result[1]), tree)


def _fill_gaps(parts: Sequence[str], found: dict[str, int], tree: Tree) -> dict[str, int]:
    """Set a part that is missing between two others to the only bone between them.

    A collar directly above an elbow is the upper arm, whatever its name.
    """
    for k, part in enumerate(parts[1:-1], start=1):
        upper, lower = found.get(parts[k - 1]), found.get(parts[k + 1])
        if part in found or upper is None or lower is None:
            continue
        between = tree.between(upper, lower)
        if len(between) == 1:
            found[part] = between[0]
        elif part == "shoulder" and not between:
            found[part] = found.pop("collar")
    return found


def _fingers(
    side: str, free: Sequence[int], words: list[list[str]], tree: Tree, wrist: int | None
) -> dict[str, int]:
    """Return joint -> bone for the first three bones of each finger of a hand."""
    result: dict[str, int] = {}
    if wrist is None:
        return result
    on_hand = [bone for bone in free if wrist in tree.above(bone)]
    for finger in maps.FINGERS:
        bones = sorted(
            (bone for bone in on_hand if _score(words[bone], finger) > 0), key=lambda bone: tree.depth[bone]
        )
        if len({tree.depth[bone] for bone in bones}) == len(bones) >= 3:
            result |= {f"{side}_{finger}{k}": bone for k, bone in enumerate(bones[:3], start=1)}
    return result


def _trunk(
    middle: Sequence[int], words: list[list[str]], tree: Tree, limbs: dict[str, int]
) -> dict[str, int]:
    """Return joint -> bone for pelvis, spine, neck and head.

    The pelvis is the lowest bone above both legs and arms; the spine leads from there to the neck.
    """
    chosen: dict[str, int] = {}
    attached = [
        limbs[f"{side}_{joint}"]
        for joint in ("hip", "shoulder")
        for side in ("left", "right")
        if f"{side}_{joint}" in limbs
    ]
    pelvis = _common_parent(tree, attached) if len(attached) > 1 else _best(middle, words, "pelvis")
    if pelvis is None:
        return chosen
    chosen["pelvis"] = pelvis
    above = [bone for bone in middle if pelvis in tree.above(bone)]
    head, neck = (_best(above, words, part) for part in ("head", "neck"))
    if neck is not None:
        chosen["neck"] = neck
    if head is not None:
        chosen["head"] = head
    top = neck if neck is not None else head
    spine = tree.between(pelvis, top) if top is not None else _named(above, words, "spine", tree)
    for joint, bone in zip(*spine_joints(spine), strict=True):
        chosen[joint] = bone
    return chosen


def _common_parent(tree: Tree, bones: Sequence[int]) -> int | None:
    """Return the nearest bone that is above all of these, or None."""
    others = [set(tree.above(bone)) for bone in bones[1:]]
    return next((bone for bone in tree.above(bones[0]) if all(bone in above for above in others)), None)


def _best(bones: Sequence[int], words: list[list[str]], part: str) -> int | None:
    """Return the first bone whose name fits a part best, or None."""
    scored = [(_score(words[bone], part), bone) for bone in bones]
    best = max(scored, key=lambda pair: pair[0], default=(0.0, None))
    return best[1] if best[0] > 0 else None


def _named(bones: Sequence[int], words: list[list[str]], part: str, tree: Tree) -> list[int]:
    """Return the bones whose names fit a part, from above."""
    return sorted(
        (bone for bone in bones if _score(words[bone], part) > 0), key=lambda bone: tree.depth[bone]
    )
