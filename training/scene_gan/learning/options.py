"""Options of a training: the networks' settings, the critics, the optimiser."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ....models.scene_gan.networks import Settings

CRITICS = ("trajectory", "pose", "projection", "context")
PARTS = ("all", "trajectory", "pose", "rough_pose")


@dataclass(frozen=True)
class Options:
    """Settings of one training.

    critics: names in CRITICS. depth: whether the encoder was pretrained on depth (D of table 1). part: train both
    generators together, the trajectory generator alone, the pose generator on true trajectories, or only its dense
    part, which does not see the scene. critic_steps: per step of the generators. along: train the encoder together with
    the generators instead of caching its features. average: decay of the weights' running average, per step. crop: size
    of the context critic's crops. context_weight: of the context critic's score in the generators' loss; its gradient
    on the pelvis is hundreds of times those of the others. draws: of each window, whose nearest one is drawn to the
    true window; 0 trains by the critics alone, as the paper does. draws_weight: of its error in the generators' loss.
    spectral: weight of the spectra of velocities in that error. kept: beginnings of the names of weights that
    are not trained. moving: share of each batch in which bodies travel, for poses on true trajectories.
    """

    settings: Settings = Settings()
    critics: tuple[str, ...] = CRITICS
    depth: bool = True
    part: str = "all"
    batch: int = 64
    rate: float = 2e-4
    critic_steps: int = 2
    along: bool = False
    average: float = 0.999
    crop: tuple[int, int] = (36, 64)
    context_weight: float = 1.0
    draws: int = 0
    draws_weight: float = 1.0
    spectral: float = 0.0
    kept: tuple[str, ...] = ()
    moving: float = 0.0
    seed: int = 0

    @property
    def sees_scene(self) -> bool:
        """Whether the trained part sees the scene."""
        return self.part != "rough_pose"

    def __post_init__(self) -> None:
        unknown = set(self.critics) - set(CRITICS)
        if unknown or self.part not in PARTS:
            raise ValueError(f"unknown critic or part {sorted(unknown) or self.part!r}")


_APART = ("trajectory", "pose")
ROWS = {
    "csgn": Options(Settings(separate=False), critics=("pose",), depth=False),
    "m": Options(critics=_APART, depth=False),
    "md": Options(critics=_APART),
    "mdc": Options(critics=(*_APART, "context")),
    "mdp": Options(critics=(*_APART, "projection")),
    "all": Options(),
    "height": Options(Settings(view="height")),
    "geometry": Options(Settings(view="geometry")),
}
"""The rows of table 1, and views that are not in the paper."""


def row(name: str, **changes: object) -> Options:
    """Return the options of a row with changes, by name, including those of the networks' settings."""
    base = ROWS[name]
    inner = {k: v for k, v in changes.items() if k in Settings.__dataclass_fields__ and v is not None}
    outer = {k: v for k, v in changes.items() if k not in inner and v is not None}
    return replace(base, settings=replace(base.settings, **inner), **outer)
