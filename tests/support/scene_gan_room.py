"""A room in which bodies improvise."""

import shapes
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.methods.scene_gan.ground import Ground
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from samp_blender.samp_addon.scene.navmesh import navmesh

STANDING = -human.load().floor


def room():
    """A floor of 6 x 6 m with a box of 2 x 0.9 x 1 m in its middle and a low bench on one side."""
    pieces = [
        ("Floor", shapes.box([-3, -0.1, -3], [3, 0, 3])), ("Box", shapes.box([-1, 0, -0.5], [1, 0.9, 0.5])),
        ("Bench", shapes.box([-2.9, 0, 1.5], [-2.4, 0.45, 2.5])),
    ]  # fmt: skip
    return SceneGeometry.from_objects(pieces)


def ground(made):
    return Ground(navmesh.build(made.triangles), made.triangles, STANDING)
