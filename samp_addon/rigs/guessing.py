"""A first answer to which bone of an unknown humanoid is which joint, by words in bones' names and what hangs from
what; the artist corrects it."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from . import maps

# Words of a name that make it a part, the surest first; each is a run of letters without gaps.
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
# What hangs on a limb and is none of its joints.
HELPERS = (
    "twist", "roll", "ik", "pole", "target", "end", "nub", "tip", "helper", "mch", "metacarpal", "palm", "ctrl",
    "control", "socket", "jiggle", "corrective", "share", "muscle", "weapon", "prop", "eye", "jaw",
)  # fmt: skip
_LEFT, _RIGHT = ("l", "left", "lft"), ("r", "right", "rgt")
_LIMBS = (("hip", "knee", "ankle", "foot"), ("collar", "shoulder", "elbow", "wrist"))


def guess(names: Sequence[str], parents: Sequence[int], heads: np.ndarray) -> dict[str, str]:
    """Joint -> bone, of bones with these names (B,), parents (B,) and heads (B, 3); what cannot be told is left out.

    A gap in a limb is filled by the bone that lies in it.
    """
    words = [_words(name) for name in names]
    tree = _Tree(parents)
    sides = _sides(words, tree)
    chosen: dict[str, int] = {}
    for side in ("left", "right"):
        free = [bone for bone in range(len(names)) if sides[bone] == side and not _helper(words[bone])]
        for limb in _LIMBS:
            chosen |= {f"{side}_{part}": bone for part, bone in _limb(limb, free, words, tree).items()}
        chosen |= _fingers(side, free, words, tree, chosen.get(f"{side}_wrist"))
    middle = [bone for bone in range(len(names)) if sides[bone] is None and not _helper(words[bone])]
    chosen |= _trunk(middle, words, tree, chosen)
    return {joint: names[chosen[joint]] for joint in maps.JOINTS if joint in chosen}


class _Tree:
    """What hangs from what."""

    def __init__(self, parents: Sequence[int]) -> None:
        self.parents = [int(parent) for parent in parents]
        self.depth = [len(self.above(bone)) for bone in range(len(self.parents))]

    def above(self, bone: int) -> list[int]:
        """All bones that a bone hangs from, the nearest first."""
        result = []
        while (bone := self.parents[bone]) >= 0:
            result.append(bone)
        return result

    def between(self, upper: int, lower: int) -> list[int]:
        """The bones between two, from above; none where one does not hang from the other."""
        way = self.above(lower)
        return way[: way.index(upper)][::-1] if upper in way else []


def _words(name: str) -> list[str]:
    """A bone's name in small words: what is before a colon dropped, cut at signs, digits and capitals."""
    stem = name.rsplit(":", 1)[-1]
    stem = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", stem)
    return [word.lower() for word in re.findall(r"[A-Za-z]+|\d+", stem)]


def _sides(words: list[list[str]], tree: _Tree) -> list[str | None]:
    """The side of each bone: by its own name, or by that of what it hangs from."""
    result: list[str | None] = [None] * len(words)
    for bone in sorted(range(len(words)), key=lambda bone: tree.depth[bone]):
        marks = [word for word in words[bone] if word in _LEFT + _RIGHT]
        joined = [word for word in words[bone] if word.startswith(("left", "right"))]
        if marks or joined:
            result[bone] = "left" if (marks or joined)[0][0] == "l" else "right"
        elif tree.parents[bone] >= 0:
            result[bone] = result[tree.parents[bone]]
    return result


def _helper(words: list[str]) -> bool:
    """Whether a name is that of no joint; some rigs call the neck a twist."""
    return any(word in HELPERS for word in words) and "neck" not in words


def _score(words: list[str], part: str) -> float:
    """How surely a name means a part: 0 not at all."""
    text = "".join(word for word in words if word not in _LEFT + _RIGHT and not word.isdigit())
    text = re.sub(r"^(left|right)|(left|right)$", "", text)
    for rank, word in enumerate(WORDS[part]):
        if text == word:
            return 2.0 - 0.05 * rank
        if word in text:
            return 1.0 - 0.05 * rank
    return 0.0


def _limb(parts: Sequence[str], free: Sequence[int], words: list[list[str]], tree: _Tree) -> dict[str, int]:
    """The bones of a limb that hang from one another in its order and whose names fit best."""
    best: dict[int, list[tuple[float, dict[str, int]]]] = {}
    order = sorted(free, key=lambda bone: tree.depth[bone])
    result: tuple[float, dict[str, int]] = (0.0, {})
    for bone in order:
        # For each count of parts used so far, the best way down to this bone.
        above = [way for upper in tree.above(bone) for way in best.get(upper, [])]
        ways = []
        for k, part in enumerate(parts):
            score = _score(words[bone], part)
            if score <= 0:
                continue
            before = [way for way in above if all(parts.index(used) < k for used in way[1])]
            total, used = max(before, key=lambda way: way[0], default=(0.0, {}))
            ways.append((total + score - 0.001 * tree.depth[bone], used | {part: bone}))
        best[bone] = ways
        result = max([result, *ways], key=lambda way: way[0])
    return _filled(parts, dict(result[1]), tree)


def _filled(parts: Sequence[str], found: dict[str, int], tree: _Tree) -> dict[str, int]:
    """The same with a part that is missing between two others set to the only bone between them. A collar right over
    an elbow is the upper arm, whatever it is called."""
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
    side: str, free: Sequence[int], words: list[list[str]], tree: _Tree, wrist: int | None
) -> dict[str, int]:
    """The first three bones of each finger of a hand."""
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
    middle: Sequence[int], words: list[list[str]], tree: _Tree, limbs: dict[str, int]
) -> dict[str, int]:
    """Pelvis, spine, neck and head: what carries the legs, what carries the arms, and what is above that."""
    chosen: dict[str, int] = {}
    carried = [
        limbs[f"{side}_{joint}"]
        for joint in ("hip", "shoulder")
        for side in ("left", "right")
        if f"{side}_{joint}" in limbs
    ]
    pelvis = _common(tree, carried) if len(carried) > 1 else _best(middle, words, "pelvis")
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
    for joint, bone in zip(_spine_joints(len(spine)), _ends_and_middle(spine), strict=True):
        chosen[joint] = bone
    return chosen


def _common(tree: _Tree, bones: Sequence[int]) -> int | None:
    """The nearest bone from which all of these hang."""
    others = [set(tree.above(bone)) for bone in bones[1:]]
    return next((bone for bone in tree.above(bones[0]) if all(bone in above for above in others)), None)


def _best(bones: Sequence[int], words: list[list[str]], part: str) -> int | None:
    """The bone whose name fits a part best; of several the first."""
    scored = [(_score(words[bone], part), bone) for bone in bones]
    best = max(scored, key=lambda pair: pair[0], default=(0.0, None))
    return best[1] if best[0] > 0 else None


def _named(bones: Sequence[int], words: list[list[str]], part: str, tree: _Tree) -> list[int]:
    return sorted(
        (bone for bone in bones if _score(words[bone], part) > 0), key=lambda bone: tree.depth[bone]
    )


def _spine_joints(count: int) -> tuple[str, ...]:
    return {0: (), 1: ("spine3",), 2: ("spine1", "spine3")}.get(count, ("spine1", "spine2", "spine3"))


def _ends_and_middle(spine: list[int]) -> list[int]:
    """At most three of the bones, the ends among them."""
    return spine if len(spine) <= 2 else [spine[0], spine[len(spine) // 2], spine[-1]]
