"""A cast read from the artist's scene: the members, what they see of it, and who else is there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...errors import SampError, UsageError
from ...methods.scene_view import SceneView
from ...methods.step import Step
from ...pipeline.cast.cast import Cast, Member
from ...pipeline.cast.role import CastWork, Role
from ...scene.geometry import SceneGeometry
from ...vocabulary import SEATED
from ..actions import refine_action
from ..character import characters
from ..overlays import start_marker
from ..rigs import performers
from ..scene import preconditions, read_scene, read_view
from ..takes import seen
from . import furniture, looking, others


@dataclass(frozen=True)
class CastPlan:
    """A cast read from the scene. geometry: of all furniture. owners: the members' armatures, None for each that is to
    be made. frame_start: of the takes."""

    work: CastWork
    geometry: SceneGeometry
    owners: tuple[bpy.types.Object | None, ...]
    frame_start: int


def read(context: bpy.types.Context, cast: Cast, from_markers: bool = False) -> CastPlan:
    """Return all that the cast needs of the scene. Raise SampError, naming the member, where something is missing.

    from_markers: members without a start begin at their start markers.
    """
    people = characters.people(context)
    owners = tuple(_named(member, lambda member=member: _owner(context, member)) for member in cast.members)
    people += [owner for owner in owners if owner is not None and owner not in people]
    strangers = others.moving(context, people, owners)
    geometry = read_scene.read_scene(context, [*people, *strangers])
    reader = _Reader(context, geometry, [*people, *strangers], cast, from_markers)
    members = [member.name for member in cast.members]
    roles = [
        _named(member, lambda member=member, owner=owner: reader.role(member, owner))
        for member, owner in zip(cast.members, owners, strict=True)
    ]
    roles = [
        replace(
            role,
            looks_at=_named(role.member, lambda role=role: _looked_at(context, role.member, members, owners)),
        )
        for role in roles
    ]
    present = others.present(context, [*people, *strangers], owners)
    work = CastWork(cast, roles, present)
    if cast.refine:
        work = replace(work, surroundings=refine_action.surroundings(context, geometry))
    return CastPlan(work, geometry, owners, context.scene.frame_start)


class _Reader:
    """Reads members of one scene; what several of them see is read once."""

    def __init__(
        self,
        context: bpy.types.Context,
        geometry: SceneGeometry,
        people: Sequence[bpy.types.Object],
        cast: Cast,
        from_markers: bool,
    ) -> None:
        self.context, self.geometry, self.people = context, geometry, people
        self.from_markers = from_markers
        self._views: dict[str, SceneView] = {}
        self._pieces: dict[str, tuple[str, ...]] = {}
        lasts = [name for member in cast.members for name in member.targets or (_target(member),)]
        self._shared = {name for name in lasts if name and lasts.count(name) > 1}

    def role(self, member: Member, owner: bpy.types.Object | None) -> Role:
        """Return a member with what it sees of the scene."""
        pieces = self._pieces_of(member)
        begin = read_view.start_of(member.job.start, owner)
        if owner is not None and member.job.start is None and self.from_markers:
            begin = start_marker.place(self.context, owner)
        steps, views = member.job.steps, []
        for name in pieces:
            row = (*steps[:-1], replace(steps[-1], target=name))
            views.append(
                tuple(
                    replace(self._view(step, number == 0, owner), start=begin)
                    for number, step in enumerate(row)
                )
            )
        self._check(member, owner, views)
        body = performers.body_of(owner)
        return Role(member, pieces, tuple(views), body)

    def _check(
        self, member: Member, owner: bpy.types.Object | None, views: list[tuple[SceneView, ...]]
    ) -> None:
        found = [self.context.scene.objects.get(step.target) for step in member.job.steps if step.target]
        seen.require_still(self.context, owner, [obj for obj in found if obj is not None])
        for own in views:
            preconditions.check(self.context, owner, own)

    def _pieces_of(self, member: Member) -> tuple[str, ...]:
        """Return the pieces of furniture of which a member takes one."""
        names = member.targets or (_target(member),)
        if member.job.steps[-1].action not in SEATED:
            return names[:1]
        found: list[str] = []
        for name in names:
            if name not in self._pieces:
                whole = len(names) == 1 and name not in self._shared
                self._pieces[name] = (name,) if whole else furniture.pieces(self.context, name)
            found += [piece for piece in self._pieces[name] if piece not in found]
        return tuple(found)

    def _view(self, step: Step, first: bool, owner: bpy.types.Object | None) -> SceneView:
        key = repr((step, first, owner.name if owner is not None and read_view.passes_stored(step) else ""))
        if key not in self._views:
            self._views[key] = read_view.read_view(
                self.context, step, self.geometry, None, self.people, first, owner
            )
        return self._views[key]


def _looked_at(
    context: bpy.types.Context,
    member: Member,
    names: Sequence[str],
    owners: Sequence[bpy.types.Object | None],
) -> np.ndarray | int | None:
    """Return the point or the number of the member that a member looks at. Raise SampError where there is none."""
    name = member.look_at
    if not name:
        return None
    if name in names:
        return names.index(name)
    obj = context.scene.objects.get(name)
    if obj is None:
        known = read_scene.close_names(name, [*names, *context.scene.objects.keys()])
        advice = f"did you mean {known}?" if known else "name a member of the cast or an object."
        raise SampError(f"There is no '{name}' to look at; {advice}")
    if obj in owners:
        return owners.index(obj)
    return looking.point_of(context, obj)


def _target(member: Member) -> str:
    return member.job.steps[-1].target


def _owner(context: bpy.types.Context, member: Member) -> bpy.types.Object | None:
    return performers.find(context, member.job.character) if member.job.character else None


def _named(member: Member, work: Callable[[], object]) -> object:
    """Return what the work returns; name the member in the error that it raises."""
    try:
        return work()
    except UsageError:
        raise
    except SampError as error:
        raise SampError(f"'{member.name}': {error}") from error
