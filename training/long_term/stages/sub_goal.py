"""Train the bodies at sub-goals (section 3.2): reconstruction, KL divergence, contact and collision terms."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from ....models.long_term import layout
from ....models.long_term.layers import divergence
from ....models.long_term.point_net import PointEncoder
from ....models.long_term.pose_prior import PosePrior
from ....models.long_term.sub_goal_net import SubGoalNet
from ..data import Frame, LongTermData, matrices, reflected, swapped_hands
from . import orientations
from .learner import Learner, with_pretrained_scene

POINTS = 768
RADIUS = 1.25  # metres around the pelvis
JITTER, HEIGHT_JITTER, YAW_JITTER = 0.05, 0.03, 0.1  # noise of the given position: metres, metres, radians
TILT_JITTER = 0.1  # noise of the given orientation, radians
KL_WEIGHT, WARM = 5e-3, 0.2  # weight, and share of the training over which it grows to its full value
SKIN_WEIGHT, HANDS_WEIGHT = 5.0, 0.1
CONTACT_WEIGHT, COLLISION_WEIGHT = 0.2, 10.0
TOUCHING, TRUSTED = (
    0.04,
    0.15,
)  # metres: distance of touching skin; distance within which normals separate inside and outside
GEMAN = 0.03  # distance (m) at which the Geman-McClure error is one half
RARE = 0.5  # share of the bodies that are drawn evenly over the kinds of poses instead of over time


@dataclass(frozen=True)
class Bodies:
    """A batch of bodies, each in the frame of its given place.

    given: (B, 9), the given t and r. body: (B, 65). turns: (B, 22, 3, 3). action: (B, 3), see SubGoalNet.
    cloud, normals: (B, P, 3).
    """

    given: torch.Tensor
    body: torch.Tensor
    turns: torch.Tensor
    betas: torch.Tensor
    gait: torch.Tensor
    action: torch.Tensor
    cloud: torch.Tensor
    normals: torch.Tensor


class SubGoalLearner(Learner):
    """The training of the sub-goal network. prior: pose prior. scene: the pretrained encoder of point clouds."""

    def __init__(
        self, data: LongTermData, prior: PosePrior, scene: PointEncoder | None, batch: int = 16
    ) -> None:
        super().__init__("long_term_sub_goal", with_pretrained_scene(SubGoalNet(), scene), data, batch)
        self.prior = prior
        self.net.turns.copy_(orientations.table(data))
        self.average["turns"].copy_(self.net.turns)
        self._kinds = [rows for rows in kinds(data) if len(rows)]

    def losses(self, done: float) -> dict[str, torch.Tensor]:
        b = draw(self.data, self.prior, self._rows(), mirror=bool(torch.rand(()) < 0.5))
        made, mean, log_variance = self.net(b.cloud, b.betas, b.given, b.gait, b.action, b.body)
        t, r, p, h = layout.split_body(made - b.body)
        kl = divergence(mean, log_variance)
        parts = t.abs().sum(-1).mean() + r.abs().mean() + p.abs().mean() + HANDS_WEIGHT * h.abs().mean()
        skins = self._skin(made, b.betas), self._skin(b.body, b.betas, b.turns)
        skin = (skins[0] - skins[1]).norm(dim=-1).mean()
        contact, collision = scene_terms(*skins, b.cloud, b.normals)
        loss = parts + SKIN_WEIGHT * skin + KL_WEIGHT * min(done / WARM, 1.0) * kl
        loss = loss + CONTACT_WEIGHT * contact + COLLISION_WEIGHT * collision
        return {"loss": loss, "skin_cm": 100 * skin, "kl": kl, "contact": contact, "collision": collision}

    def _rows(self) -> torch.Tensor:
        """Return frames (B,): some evenly over time, some evenly over the kinds of poses."""
        device = self.data.device
        rows = torch.randint(len(self.data), (self.batch,), device=device)
        each = max(int(RARE * self.batch) // len(self._kinds), 1)
        for k, kind in enumerate(self._kinds):
            part = rows[k * each : (k + 1) * each]
            part[:] = kind[torch.randint(len(kind), (len(part),), device=device)]
        return rows

    def _skin(
        self, body: torch.Tensor, betas: torch.Tensor, turns: torch.Tensor | None = None
    ) -> torch.Tensor:
        """Return the skin (B, V, 3) of bodies (B, 65); turns: (B, 22, 3, 3) in place of the decoded pose."""
        t, r, p, _ = layout.split_body(body)
        if turns is None:
            turns = torch.cat([layout.matrix_from_six(r)[:, None], self.prior.decode(p)], 1)
        model = self.data.model
        rest = model.rest_joints(betas)
        return model.skin(*model.joints(t, turns, rest), rest, betas)


def kinds(data: LongTermData) -> list[torch.Tensor]:
    """Return the frames of walking, standing, and each other label."""
    return [(data.labels == label).nonzero()[:, 0] for label in torch.unique(data.labels)]


def draw(data: LongTermData, prior: PosePrior, rows: torch.Tensor, mirror: bool) -> Bodies:
    """Return the bodies of frames (B,), with given places perturbed by noise."""
    count, device = len(rows), data.device
    noise = lambda sigma, size=(): sigma * torch.randn(count, *size, device=device)
    root, quats, yaw, gait = (
        data.root[rows],
        data.quats[rows],
        orientations.facing(data, rows),
        data.gait[rows],
    )
    hands, episode = data.hands[rows], data.episode[rows]
    chosen = data.near(data.rooms[episode], root[:, None], POINTS, RADIUS)[..., None].expand(-1, -1, 3)
    cloud, normals = (torch.gather(v[data.rooms[episode]], 1, chosen) for v in (data.points, data.normals))
    if mirror:
        root, quats, yaw, gait = reflected(root), data.mirrored(quats), -yaw, -gait
        hands, cloud, normals = swapped_hands(hands), reflected(cloud), reflected(normals)
    place = root * root.new_tensor([1.0, 0.0, 1.0]) + noise(JITTER, (3,)) * root.new_tensor([1.0, 0.0, 1.0])
    back = layout.about_y(-(yaw + noise(YAW_JITTER)))
    seen = Frame(place, back, data.rooms[episode])
    turns = matrices(quats)
    turns = torch.cat([(back @ turns[:, 0])[:, None], turns[:, 1:]], 1)
    t = seen.points(root[:, None])[:, 0]
    wanted = torch.zeros_like(t)
    wanted[:, 1] = t[:, 1] + noise(HEIGHT_JITTER)
    about = layout.about_y(-yaw) @ matrices(quats[:, 0])
    tilted = orientations.tilt(noise(TILT_JITTER, (3,))) @ about
    p = prior.encode(turns[:, 1:])[0]
    body = torch.cat([t, layout.six_from_matrix(turns[:, 0]), p, hands], -1)
    return Bodies(
        torch.cat([wanted, layout.six_from_matrix(tilted)], -1), body, turns, data.betas[episode], gait,
        orientations.actions(data, rows), seen.points(cloud), normals @ back.transpose(1, 2),
    )  # fmt: skip


def scene_terms(
    made: torch.Tensor, true: torch.Tensor, cloud: torch.Tensor, normals: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the contact and the collision term of skins (B, V, 3) against points and normals (B, P, 3).

    Contact: the Geman-McClure error of skin in contact on the true body. Collision: mean depth behind the nearest
    points, metres, in excess of the true skin's own depth, as in cushions.
    """
    depth, near = signed(made, cloud, normals)
    with torch.no_grad():
        known, close = signed(true, cloud, normals)
        touches = (known.abs() < TOUCHING) & (close < TRUSTED)
    square = depth.square()
    contact = (square / (square + GEMAN**2))[touches].mean() if bool(touches.any()) else depth.sum() * 0
    inside = torch.relu(-depth - torch.relu(-known)) * (near < TRUSTED)
    return contact, inside.mean()


def signed(
    skin: torch.Tensor, cloud: torch.Tensor, normals: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the distance (B, V), metres, along the nearest point's normal, negative behind it, and to the point."""
    with torch.no_grad():
        nearest = torch.cdist(skin, cloud).argmin(-1)[..., None].expand(-1, -1, 3)
    point, normal = torch.gather(cloud, 1, nearest), torch.gather(normals, 1, nearest)
    away = skin - point
    return (away * normal).sum(-1), away.norm(dim=-1)
