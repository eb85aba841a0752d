"""The character: find and calibrate SMPL-X armatures, create the default human."""
