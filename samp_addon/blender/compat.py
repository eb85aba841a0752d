"""All differences between Blender 4.2 and 5.x. No other file checks the version."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import numpy as np

SLOTTED = bpy.app.version >= (4, 4, 0)  # Actions hold slots, layers and strips
EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0, 0) else "BLENDER_EEVEE_NEXT"


def version() -> str:
    """Return Blender's version, such as 4.2.3."""
    return bpy.app.version_string


def _channelbag(action: bpy.types.Action, slot: object, create: bool) -> object | None:
    """Return the f-curves of a slot in the action's first keyframe strip, or None."""
    if not action.layers:
        if not create:
            return None
        action.layers.new("Layer")
    layer = action.layers[0]
    if not layer.strips:
        if not create:
            return None
        layer.strips.new(type="KEYFRAME")
    return layer.strips[0].channelbag(slot, ensure=create)


class CurveWriter:
    """Adds f-curves in bulk to an Action for one armature object, in a new slot or the given one."""

    def __init__(self, action: bpy.types.Action, owner: bpy.types.Object, slot: object | None = None) -> None:
        self.action = action
        self.slot = slot
        self._bag = action
        if SLOTTED:
            self.slot = slot or action.slots.new(id_type="OBJECT", name=owner.name)
            self._bag = _channelbag(action, self.slot, create=True)

    @classmethod
    def on_copy(cls, action: bpy.types.Action, owner: bpy.types.Object) -> CurveWriter:
        """Copy an action; return a writer to the copy for the slot that the owner uses."""
        copy = action.copy()
        slot = _slot_for(owner, action) if SLOTTED else None
        return cls(copy, owner, slot and next(twin for twin in copy.slots if twin.handle == slot.handle))

    def find(self, path: str, index: int) -> bpy.types.FCurve | None:
        """Return the existing f-curve of this property, or None."""
        return self._bag.fcurves.find(path, index=index)

    def remove(self, curve: bpy.types.FCurve) -> None:
        """Remove an f-curve."""
        self._bag.fcurves.remove(curve)

    def add(
        self, path: str, index: int, frames: np.ndarray, values: np.ndarray, group: str
    ) -> bpy.types.FCurve:
        """Add an f-curve with linear keys at frames (n,) of values (n,)."""
        curve = self._new_curve(path, index, group)
        points = curve.keyframe_points
        points.add(len(frames))
        points.foreach_set("co", np.stack([frames, values], axis=1).astype(np.float32).ravel())
        linear = points[0].bl_rna.properties["interpolation"].enum_items["LINEAR"].value
        points.foreach_set("interpolation", np.full(len(frames), linear, dtype=np.int32))
        curve.update()
        return curve

    def _new_curve(self, path: str, index: int, group: str) -> bpy.types.FCurve:
        if not SLOTTED:
            return self._bag.fcurves.new(path, index=index, action_group=group)
        if bpy.app.version >= (5, 0, 0):
            return self._bag.fcurves.new(path, index=index, group_name=group)
        curve = self._bag.fcurves.new(path, index=index)
        curve.group = self._bag.groups.get(group) or self._bag.groups.new(group)
        return curve


def assign(owner: bpy.types.Object, action: bpy.types.Action, slot: object | None = None) -> None:
    """Make the action the object's active one, with this slot or else the matching one."""
    data = owner.animation_data or owner.animation_data_create()
    data.action = action
    if SLOTTED and action is not None:
        data.action_slot = slot or _slot_for(owner, action)


def fit_strip(strip: bpy.types.NlaStrip, owner: bpy.types.Object) -> None:
    """Set the slot of an NLA strip to the one for this object."""
    if SLOTTED and strip.action_slot is None:
        strip.action_slot = _slot_for(owner, strip.action)


def _slot_for(owner: bpy.types.Object, action: bpy.types.Action) -> object | None:
    """Return the slot of an action for an object: its active slot, the one of its name, or the first for objects."""
    data = owner.animation_data
    if data is not None and data.action == action and data.action_slot is not None:
        return data.action_slot
    slots = [slot for slot in action.slots if slot.target_id_type in ("OBJECT", "UNSPECIFIED")]
    return next((slot for slot in slots if slot.name_display == owner.name), slots[0] if slots else None)


def curves(action: bpy.types.Action, owner: bpy.types.Object) -> Iterator[bpy.types.FCurve]:
    """Yield the f-curves of an action that animate an object."""
    if not SLOTTED:
        yield from action.fcurves
        return
    slot = _slot_for(owner, action)
    bag = _channelbag(action, slot, create=False) if slot is not None else None
    if bag is not None:
        yield from bag.fcurves


def select_bone(armature: bpy.types.Object, name: str, state: bool = True) -> None:
    """Select or deselect a bone in Pose Mode."""
    bone = armature.pose.bones[name] if bpy.app.version >= (5, 0, 0) else armature.data.bones[name]
    bone.select = state


def new_shape_key(mesh: bpy.types.Object, name: str, value: float = 0.0) -> bpy.types.ShapeKey:
    """Add a shape key with this value; Blender 5 creates them with value 1."""
    key = mesh.shape_key_add(name=name, from_mix=False)
    key.slider_max = max(1.0, value)  # values beyond it are cut off
    key.value = value
    return key


def new_node_material(name: str) -> bpy.types.Material:
    """Create a material with shader nodes; in Blender 5 every material has them."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    return material


def import_fbx(filepath: str) -> None:
    """Import an FBX file with the built-in importer of Blender 4.5 and later, or the older add-on."""
    if "fbx_import" in dir(bpy.ops.wm):
        bpy.ops.wm.fbx_import(filepath=filepath)
        return
    import addon_utils

    addon_utils.enable("io_scene_fbx", default_set=False)
    bpy.ops.import_scene.fbx(filepath=filepath)


def import_usd(filepath: str) -> None:
    """Import a USD file; objects get the names of their transforms, which are those of the exported objects."""
    known = bpy.ops.wm.usd_import.get_rna_type().properties
    # Older versions always merge a transform with its mesh and keep the mesh's name.
    options = {"merge_parent_xform": False} if "merge_parent_xform" in known else {}
    bpy.ops.wm.usd_import(filepath=filepath, **options)


def export(kind: str, path: str, first: int, last: int) -> None:
    """Export the selection with its animation in a frame range, by Blender's own exporter."""
    import addon_utils

    module = {"FBX": "io_scene_fbx", "BVH": "io_anim_bvh", "GLTF": "io_scene_gltf2"}.get(kind)
    if module is not None and not addon_utils.check(module)[1]:
        addon_utils.enable(module, default_set=False)
    if kind == "FBX":
        bpy.ops.export_scene.fbx(
            filepath=path, use_selection=True, add_leaf_bones=False, bake_anim_use_nla_strips=False,
            bake_anim_use_all_actions=False, bake_anim_simplify_factor=0.0,
        )  # fmt: skip
    elif kind == "BVH":
        # "Root translation only" would lose the pelvis's, which has a root bone above it.
        bpy.ops.export_anim.bvh(filepath=path, frame_start=first, frame_end=last, root_transform_only=False)
    elif kind == "USD":
        bpy.ops.wm.usd_export(filepath=path, selected_objects_only=True, export_animation=True)
    else:
        bpy.ops.export_scene.gltf(
            filepath=path,
            use_selection=True,
            export_animation_mode="ACTIVE_ACTIONS",
            export_frame_range=False,
        )
