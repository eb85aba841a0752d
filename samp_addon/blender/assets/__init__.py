"""Takes and characters as assets of Blender's Asset Library."""
