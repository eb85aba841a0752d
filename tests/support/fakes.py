"""What stands for the networks in tests of everything around them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from samp_blender.samp_addon import frames, rotation, skeleton
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.errors import RolloutError, SampError
from samp_blender.samp_addon.methods.samp.method import Samp
from samp_blender.samp_addon.methods.samp.networks import Networks
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.pipeline.driver import Toolbox
from samp_blender.samp_addon.refine.refinement import Refined, Settings
from samp_blender.samp_addon.scene.seats import seats
from samp_blender.samp_addon.vocabulary import ACTIONS

SPEED = 1.2


def generate(requests, progress=lambda share: None):
    """Glides along the way-points, then to the goal, and stays there; no two seeds are equal."""
    made = []
    for count, request in enumerate(requests):
        progress(count / len(requests))
        made.append(_glide(request))
    return made


def _glide(request):
    height = -human.load().floor
    seated = request.action in ("sit", "lie")
    end = np.asarray(request.goal.position) + (0 if seated else np.array([0.0, height, 0.0]))
    points = [*(np.asarray(request.waypoints) + [0.0, height, 0.0]), end]
    walk = []
    for a, b in zip(points[:-1], points[1:], strict=True):
        steps = max(int(np.linalg.norm(b - a) / SPEED * 30), 1)
        walk += list(np.linspace(a, b, steps, endpoint=False))
    begun = len(walk)
    wobble = np.random.default_rng(request.seed).normal(size=3) * 0.01
    root = np.array(walk + [end + wobble] * (int(request.hold_seconds * 30) + 1))
    yaw = np.full(len(root), frames.direction_yaw(request.goal.direction))
    rotations = np.zeros((len(root), 22, 4))
    rotations[..., 0] = 1
    rotations[:, 0] = rotation.about_y(yaw)
    actions = np.zeros((len(root), len(ACTIONS)))
    actions[:begun, 1], actions[begun:, ACTIONS.index(request.action)] = 1, 1
    return Motion(
        root,
        rotations,
        contacts=np.zeros((len(root), 5)),
        actions=actions,
        interaction_start=begun if seated else None,
    )


def never(requests, progress=lambda share: None):
    """A generator that no seed gets to the goal."""
    return [RolloutError("The character got stuck; try another seed.") for _ in requests]


_FOUND = {}


def sample_goals(triangles, action, count, seed, obstacles, floor=None):
    """By geometry, the seed choosing among the best; an object is searched once."""
    key = triangles.tobytes(), action, floor
    found = _FOUND.setdefault(key, seats.find_goals(triangles, action, floor) if key not in _FOUND else None)
    return [found[(seed + k) % len(found)] for k in range(count)] if found else []


RAISED, BENT = 0.02, 0.3


def refine(
    motion, surroundings, goal=None, body=None, settings=None, progress=lambda stage, share: None, hands=()
):
    """Raises the body by 2 cm and bends its left knee by 0.3 rad more, in all frames."""
    if not len(surroundings.triangles):
        raise SampError("Nothing stands near the character; show the furniture.")
    for share in (0.0, 0.5):
        progress("Windows", share)
    strength = (settings or Settings()).strength
    quats, knee = motion.rotations.copy(), skeleton.INDEX["left_knee"]
    bend = rotation.from_axis_angle(np.array([BENT * strength, 0.0, 0.0]))
    quats[:, knee] = rotation.multiply(quats[:, knee], bend)
    before = {"penetration_max_cm": 4.0, "foot_slide_cm_s": 5.0, "contact": 0.9}
    after = {"penetration_max_cm": 0.5, "foot_slide_cm_s": 1.0, "contact": 1.0}
    raised = motion.root + [0.0, RAISED * strength, 0.0]
    return Refined(replace(motion, root=raised, rotations=quats), before, after, 0.04, ("It was a fake.",))


def toolbox(generate=generate, sample_goals=sample_goals, refine=refine):
    """The driver's tools with these parts."""
    return Toolbox({Samp.name: Samp(Networks(sample_goals, generate))}, refine)


NETWORKS = Networks(sample_goals, generate)
TOOLS = toolbox()
STUCK = toolbox(never)
