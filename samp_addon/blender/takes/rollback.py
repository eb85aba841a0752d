"""What a job that stops half-way has made is removed again."""

from __future__ import annotations

import bpy


class Rollback:
    """Called, removes what was made since it was constructed, and restores the selection."""

    KINDS = ("actions", "objects", "meshes", "armatures", "materials", "collections")

    def __init__(self, context: bpy.types.Context) -> None:
        self.layer = context.view_layer
        self.active = self.layer.objects.active
        self.selected = list(context.selected_objects)
        self.present = {kind: set(getattr(bpy.data, kind)) for kind in self.KINDS}

    def __call__(self) -> None:
        for kind in self.KINDS:
            data = getattr(bpy.data, kind)
            for made in set(data) - self.present[kind]:
                data.remove(made)
        left = set(bpy.data.objects)  # the artist may have deleted something meanwhile
        for thing in self.selected:
            if thing in left:
                thing.select_set(True)
        if self.active is None or self.active in left:
            self.layer.objects.active = self.active
