"""Faults of characters: linked, overridden, locked, scaled, posed, shared, or of another rig."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import fakes
from faults import Case, Room, activate, add, both, meanwhile, nothing, press, seated_on, with_take
from samp_blender.samp_addon.blender import compat
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.takes import measure
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.tests.support.blender import rigs

CHARACTER_NAMES = {
    "quotes": "Anna \"the\" 'Great'",
    "an emoji": "🧍 Zoë",
    "63 characters": "h" * 63,
    "a backslash and brackets": 'An\\na["x"]',
}


def change(act: Callable[[bpy.types.Object], object]):
    """Return a change of the human."""
    return lambda room: act(room.owner)


def library(room: Room) -> bpy.types.Object:
    """Link the human from another file."""
    path = room.files / "people.blend"
    bpy.data.libraries.write(str(path), {room.owner, *room.owner.children})
    for thing in (*room.owner.children, room.owner):
        bpy.data.objects.remove(thing)
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    with bpy.data.libraries.load(str(path), link=True) as (inside, wanted):
        wanted.objects = inside.objects
    for thing in wanted.objects:
        room.scene.collection.objects.link(thing)
    return next(thing for thing in wanted.objects if thing.type == "ARMATURE")


def overridden(room: Room) -> None:
    linked = library(room)
    linked.override_create(remap_local_usages=True)


def linked_action(room: Room) -> None:
    """Give the human an Action linked from another file."""
    action, path = with_take(room), room.files / "actions.blend"
    bpy.data.libraries.write(str(path), {action})
    room.owner.animation_data.action = None
    bpy.data.actions.remove(action)
    with bpy.data.libraries.load(str(path), link=True) as (inside, wanted):
        wanted.actions = inside.actions
    compat.assign(room.owner, wanted.actions[0])


def locked_curves(room: Room) -> None:
    action = with_take(room)
    for curve in compat.curves(action, room.owner):
        curve.lock = curve.mute = True


def tweaked(room: Room) -> None:
    action, data = with_take(room), room.owner.animation_data
    strip = data.nla_tracks.new().strips.new("Old", 1, action)
    data.action = None
    strip.select = data.nla_tracks[0].select = True
    data.nla_tracks.active = data.nla_tracks[0]
    data.use_tweak_mode = True
    assert data.use_tweak_mode


def in_the_nla(room: Room) -> None:
    action, data = with_take(room), room.owner.animation_data
    data.nla_tracks.new().strips.new("Old", 1, action)
    data.action = None


def with_drivers(room: Room) -> None:
    for name in ("left_knee", "head"):
        driver = room.owner.pose.bones[name].driver_add("rotation_quaternion", 1).driver
        driver.expression = "frame * 0"


def shared_slot(room: Room) -> None:
    action = with_take(room)
    other = character.create_character(bpy.context, name="Other", location=(3, 3, 0))
    slot = getattr(room.owner.animation_data, "action_slot", None)
    compat.assign(other, action, slot)
    activate(room.owner)


def edit_bones(act: Callable[[bpy.types.ArmatureEditBones], object]):
    def arrange(room: Room) -> None:
        activate(room.owner)
        bpy.ops.object.mode_set(mode="EDIT")
        act(room.owner.data.edit_bones)
        bpy.ops.object.mode_set(mode="OBJECT")

    return arrange


def without_knee(bones: bpy.types.ArmatureEditBones) -> None:
    bones.remove(bones["left_knee"])


def bent_rest_pose(bones: bpy.types.ArmatureEditBones) -> None:
    bones["left_elbow"].head.z -= 0.5
    bones["left_wrist"].head.z -= 1.0


def another_rig(room: Room) -> None:
    """Add and activate an armature of one bone."""
    rig = add("armatures", "Rig", at=(3, 3, 0))
    activate(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones.new("Bone").tail = 0, 0, 1
    bpy.ops.object.mode_set(mode="OBJECT")


def parented(room: Room) -> None:
    parent = add("", "Cart", at=(0.5, 0.5, 0.0))
    parent.rotation_euler.z = 1.0
    bpy.context.view_layer.update()
    kept = room.owner.matrix_world.copy()
    room.owner.parent = parent
    room.owner.matrix_world = kept


def second_human(room: Room) -> None:
    character.create_character(bpy.context, name="Second", location=(3, 3, 0))
    activate(None)


def meshcapade(room: Room) -> None:
    """Replace the human by an armature in centimetres with Y up."""
    place = room.owner.location.copy()
    for thing in (*room.owner.children, room.owner):
        bpy.data.objects.remove(thing)
    rigs.make("meshcapade", name="Human").location = place


def reaches(room: Room) -> None:
    """Assert success with longer legs: the pelvis is higher than in the take, but on the seat."""
    assert measure.measure_take(bpy.context)[1]["success"] is True


def euler(owner: bpy.types.Object) -> None:
    for bone in owner.pose.bones:
        bone.rotation_mode = "XYZ"
        bone.lock_rotation = bone.lock_location = (True,) * 3


def constrained(owner: bpy.types.Object) -> None:
    owner.pose.bones["pelvis"].constraints.new("LIMIT_LOCATION").use_max_z = True
    owner.pose.bones["left_foot"].constraints.new("IK")


def told_of_bones(room: Room) -> None:
    """Assert that the take is measured as Blender shows it, with a warning that names the constraint."""
    _, numbers = measure.measure_take(bpy.context)
    assert numbers["success"] is False
    assert "'Limit Location' of its bone 'pelvis'" in room.owner.animation_data.action["samp_warnings"]


def shared_bones(room: Room) -> None:
    twin = room.owner.copy()
    twin.name, twin.location = "Twin", (3, 3, 0)
    room.scene.collection.objects.link(twin)
    activate(room.owner)


def removed_action(room: Room) -> None:
    bpy.data.actions.remove(bpy.data.actions["Old"])


REFINE = press("refine")

CASES = (
    Case("linked character", lambda room: library(room), message="library override"),
    Case("overridden character", overridden),
    Case("linked Action", linked_action),
    Case("locked and muted curves", locked_curves),
    Case("locked curves, refined", locked_curves, press=REFINE, changes=(r"actions/Old\.use_fake_user",)),
    Case("linked Action, refined", linked_action, press=REFINE),
    Case("tweak mode of the NLA", tweaked, message="tweak mode"),
    Case(
        "tweak mode of the NLA, refined",
        tweaked,
        message="tweak mode",
        press=press("refine", action_name="Old"),
    ),
    Case("strips in the NLA", in_the_nla),
    Case("drivers on bones", with_drivers),
    Case("an Action shared with another character", shared_slot),
    Case("two characters, none selected", second_human, message="several characters"),
    Case(
        "two characters, one named",
        second_human,
        press=lambda room: bpy.ops.samp.sit_here("EXEC_DEFAULT", True, target="Sofa", character="Human"),
    ),
    Case("two characters, one selected", both(second_human, lambda room: activate(room.owner))),
    Case(
        "two characters, export",
        second_human,
        message="several characters",
        press=lambda room: bpy.ops.samp.export_npz("EXEC_DEFAULT", True, filepath=str(room.files / "a.npz")),
    ),
    Case(
        "a character that is not there",
        nothing,
        message="no object 'Bob'",
        press=seated_on("Sofa", character="Bob"),
    ),
    Case(
        "a sofa as character",
        nothing,
        message="'Sofa' is not an armature",
        press=seated_on("Sofa", character="Sofa"),
    ),
    Case(
        "missing knee",
        edit_bones(without_knee),
        message="'Human'.*left_knee",
        press=seated_on("Sofa", character="Human"),
    ),
    Case("another rest pose", edit_bones(bent_rest_pose), message="rest pose of 'Human'"),
    Case(
        "another rig clicked, refined",
        both(with_take, another_rig),
        message="'Rig' is not an SMPL-X armature",
        press=REFINE,
    ),
    Case("mirrored character", change(lambda owner: setattr(owner, "scale", (-1, 1, 1))), message="scale"),
    Case(
        "stretched character",
        change(lambda owner: setattr(owner, "scale", (1, 1, 2))),
        message="apply its scale",
    ),
    Case(
        "character scaled to nothing",
        change(lambda owner: setattr(owner, "scale", (0, 0, 0))),
        message="scale of zero",
    ),
    Case(
        "large character",
        change(lambda owner: setattr(owner, "scale", (1.1, 1.1, 1.1))),
        press=press("sit_here", target="Sofa"),
        check=reaches,
    ),
    Case("parented character", parented),
    # A character that the artist brought is given a start with its first take.
    Case("character in centimetres", meshcapade, changes=(r"objects/Human\[custom\]",)),
    Case("locked bones with Euler angles", change(euler)),
    Case(
        "constraints on bones",
        change(constrained),
        press=press("sit_here", target="Sofa"),
        check=told_of_bones,
    ),
    Case("bones shared by two objects", shared_bones),
    Case("hidden character", change(lambda owner: owner.hide_set(True))),
    Case("character in rest position", change(lambda owner: setattr(owner.data, "pose_position", "REST"))),
    *(
        Case(
            f"a character with {what} in its name",
            change(lambda owner, name=name: setattr(owner, "name", name)),
            owner=name,
        )
        for what, name in CHARACTER_NAMES.items()
    ),
    Case(
        "no seed arrives",
        nothing,
        message="stuck",
        press=meanwhile(nothing, Job(action="sit", target="Sofa"), fakes.STUCK),
    ),
    Case(
        "refined, its Action deleted before",
        lambda room: (with_take(room), removed_action(room)),
        message="no Action",
        press=REFINE,
    ),
    Case(
        "refined, an Action that is not there",
        with_take,
        message="no Action 'Dance'",
        press=press("refine", action_name="Dance"),
    ),
    Case("measured without a take", nothing, message="has no Action", press=press("measure")),
    Case(
        "measured with an Action of 'Human' that is not there",
        nothing,
        message="no Action 'Dance'",
        press=press("measure", action_name="Dance"),
    ),
    Case(
        "refined, frames outside the Action",
        with_take,
        message="choose frames from 1 to 40",
        press=press("refine", use_range=True, frame_start=900, frame_end=901),
    ),
)
