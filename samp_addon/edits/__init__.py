"""Changes to finished takes: Motion or curves in, Motion or curves out. No Blender."""
