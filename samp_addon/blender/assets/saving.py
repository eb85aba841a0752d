"""Takes and characters saved as assets, each in a new .blend in the folder of an asset library."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ...body.figures import figure
from ...errors import SampError
from ..actions import keyframes, notes
from ..character import armature, character, materials, start
from ..controls import rig
from ..edits import origin
from ..scene.candidates import OVERLAY_KEY
from . import catalogues, thumbnail

TAKES, CHARACTERS = "SAMP/Takes", "SAMP/Characters"
TAG = "SAMP"


def make_library(folder: Path) -> None:
    """Make the folder of a library of the preferences: Blender makes it with its first asset only.

    Raise SampError where it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SampError(f"The folder '{folder}' cannot be made ({error}); choose another one.") from error


def save_take(
    context: bpy.types.Context, owner: bpy.types.Object, action: bpy.types.Action, folder: Path
) -> Path:
    """Save a take's Action as an asset; return the new .blend. The file that is open stays as it is.

    Its picture is the last pose of the take; takes of other rigs have none. Raise SampError where the folder or a file
    in it cannot be written.
    """
    picture = None
    if armature.is_smplx(owner):
        last = notes.take_end(action)
        pose = keyframes.read_motion(owner, action, last, last, context.scene)
        picture = thumbnail.of_body(character.body_of(owner), pose, 0, _colours(owner))
    seconds = (action.frame_range[1] - action.frame_range[0]) / keyframes.frames_per_second(context.scene)
    copy = action.copy()
    try:
        with _named({copy: action.name}):
            _describe(copy, TAKES, folder, _tags(action), f"A take of {seconds:.1f} s.", picture)
            return _write(folder, copy.name, {copy})
    finally:
        bpy.data.actions.remove(copy)


def save_character(owner: bpy.types.Object, folder: Path) -> Path:
    """Save an SMPL-X character as an asset; return the new .blend. The file that is open stays as it is.

    The saved character is in its rest pose, at the origin, not turned about the vertical, and has no Actions. The asset
    is the mesh, which brings its armature with it; where there are several meshes, the asset is a collection of all.
    Raise SampError where the character has a control rig, and as `save_take`.
    """
    armature.check(owner)
    if rig.find(owner) is not None:
        raise SampError(f"'{owner.name}' has a control rig; remove it before the character is saved.")
    picture = thumbnail.of_body(character.body_of(owner), figure("stand"), 0, _colours(owner))
    name = owner.name
    parts = [owner, *(obj for obj in owner.children_recursive if OVERLAY_KEY not in obj)]
    copies = {obj: obj.copy() for obj in parts}
    collection = bpy.data.collections.new(name)
    try:
        for copy in copies.values():
            collection.objects.link(copy)
            _detach(copy, copies)
        with _named({copy: obj.name for obj, copy in copies.items()}):
            look = [owner[materials.LOOK_KEY]] if materials.LOOK_KEY in owner else []
            meshes = [copy for copy in copies.values() if copy.type == "MESH"]
            # Blender writes no pictures of collections.
            block = meshes[0] if len(meshes) == 1 else collection
            _describe(block, CHARACTERS, folder, look, "A character for takes.", picture)
            return _write(folder, name, {block, *copies.values()})
    finally:
        bpy.data.collections.remove(collection)
        for copy in copies.values():
            bpy.data.objects.remove(copy)


def _detach(copy: bpy.types.Object, copies: dict[bpy.types.Object, bpy.types.Object]) -> None:
    """Let a copied object refer to the other copies, and remove its Actions, its pose and its place in the scene."""
    copy.animation_data_clear()
    if copy.parent in copies:
        copy.parent = copies[copy.parent]
    else:
        turn = copy.matrix_basis.to_euler("XYZ")
        turn.z = 0.0  # imported armatures lie on their side without the other two
        copy.parent, copy.matrix_basis = None, Matrix.LocRotScale(None, turn, copy.scale)
    for modifier in copy.modifiers:
        if getattr(modifier, "object", None) in copies:
            modifier.object = copies[modifier.object]
    for bone in copy.pose.bones if copy.pose is not None else ():
        bone.matrix_basis.identity()
    if start.START_KEY in copy:
        del copy[start.START_KEY]


def _describe(
    block: bpy.types.ID,
    catalogue: str,
    folder: Path,
    tags: Iterable[str],
    text: str,
    picture: np.ndarray | None,
) -> None:
    """Mark a data-block as an asset. picture: (H, W, 4) sRGB from 0 to 1, its lowest row first, or None.

    Raise SampError where the library's catalogues cannot be written.
    """
    if not folder.is_dir():
        raise SampError(f"There is no folder '{folder}'; choose that of an asset library.")
    block.asset_mark()
    data = block.asset_data
    data.catalog_id = catalogues.ensure(folder, catalogue)
    data.description = text
    for tag in (TAG, *tags):
        data.tags.new(tag, skip_if_exists=True)
    if picture is not None:
        preview = block.preview_ensure()
        preview.image_size = picture.shape[:2]
        preview.image_pixels_float.foreach_set(picture.astype("f").ravel())


def _write(folder: Path, name: str, blocks: set[bpy.types.ID]) -> Path:
    """Write data-blocks to a new .blend that is named after the asset."""
    stem = re.sub(r"[^\w\- ]+", "_", name).strip() or TAG
    names = itertools.chain([stem], (f"{stem} ({count})" for count in itertools.count(2)))
    path = next(path for path in (folder / f"{one}.blend" for one in names) if not path.exists())
    try:
        bpy.data.libraries.write(str(path), blocks, fake_user=True, compress=True)
    except (OSError, RuntimeError) as error:
        raise SampError(f"'{path}' cannot be written ({error}); choose another folder.") from error
    return path


@contextmanager
def _named(names: dict[bpy.types.ID, str]) -> Iterator[None]:
    """Give copies the names of their originals while a file is written. names: by the copies."""
    holders = {}
    for copy, name in names.items():
        kind = bpy.data.actions if isinstance(copy, bpy.types.Action) else bpy.data.objects
        holder = kind.get((name, None))  # the local one: a linked original does not keep its name from a copy
        if holder is not None:
            holders[holder] = name
    try:
        for holder in holders:
            holder.name = f"{TAG} saving"
        for copy, name in names.items():
            copy.name = name
        yield
    finally:
        for copy in names:
            copy.name = f"{TAG} saved"
        for holder, name in holders.items():
            holder.name = name


def _tags(action: bpy.types.Action) -> list[str]:
    """Return the tags of a take: the actions of its steps, and the names of their targets."""
    if origin.KEY not in action:
        goal = notes.read_goal(action)
        return [] if goal is None else [goal.action]
    steps = origin.read(action).job.steps
    return [word for step in steps for word in (step.action, step.target) if word]


def _colours(owner: bpy.types.Object) -> list[tuple[float, ...]]:
    """Return the linear colours of the parts of a body: those of its mesh, else of the default look."""
    plain = [materials.SURFACES[part].colour for part in materials.MATERIALS]
    mesh = next((obj for obj in owner.children if obj.type == "MESH"), None)
    slots = [] if mesh is None else [slot.material for slot in mesh.material_slots]
    if len(slots) != len(plain):
        return plain
    return [
        colour if slot is None else tuple(slot.diffuse_color[:3])
        for slot, colour in zip(slots, plain, strict=True)
    ]
