"""What a job that stops half-way has made is removed again, and nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

KINDS = ("actions", "objects", "meshes", "armatures", "materials", "collections")


class Rollback:
    """Called, removes what the job made, and restores the selection.

    The artist goes on working between two slices of writing, so only what appears inside `recording` is the job's.
    """

    def __init__(self, context: bpy.types.Context) -> None:
        self.layer = context.view_layer
        self.active = self.layer.objects.active
        self.selected = list(context.selected_objects)
        self.made: dict[str, list[bpy.types.ID]] = {kind: [] for kind in KINDS}

    @contextmanager
    def recording(self) -> Iterator[None]:
        """Count what is made inside as the job's, also if it ends with an error. Nothing else may run in between."""
        before = {kind: set(getattr(bpy.data, kind)) for kind in KINDS}
        try:
            yield
        finally:
            for kind in KINDS:
                self.made[kind] += set(getattr(bpy.data, kind)) - before[kind]

    def __call__(self) -> None:
        changed = bool(self.made["objects"])  # a new character takes the selection
        for kind, made in self.made.items():
            data = getattr(bpy.data, kind)
            for block in made:
                if _remains(data, block) and not _others_use(kind, block, self.made):
                    data.remove(block)
        left = set(bpy.data.objects)  # the artist may have deleted something meanwhile
        if not changed:
            return
        for thing in self.selected:
            if thing in left:
                thing.select_set(True)
        if self.layer.objects.active is None and (self.active is None or self.active in left):
            self.layer.objects.active = self.active


def _remains(data: bpy.types.bpy_prop_collection, block: bpy.types.ID) -> bool:
    """Whether the artist has not deleted it meanwhile."""
    try:
        return data.get(block.name) == block
    except ReferenceError:
        return False


def _others_use(kind: str, block: bpy.types.ID, made: dict[str, list[bpy.types.ID]]) -> bool:
    """Whether something that is not the job's uses a mesh, an armature or a material of the job."""
    if kind not in ("meshes", "armatures", "materials"):
        return False
    own = set(made["objects"]) | set(made["meshes"])
    users = bpy.data.user_map(subset={block})[block]
    return any(user not in own for user in users)
