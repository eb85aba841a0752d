"""Changes of a finished take that its artist asks for: Motion in, Motion out, without Blender."""
