"""Commands of the batch outside Blender: `python -m samp_blender.batch.NAME`. The code is in samp_addon/batch."""
