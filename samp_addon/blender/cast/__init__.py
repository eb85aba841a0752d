"""Several characters in a .blend file: read with their furniture and the other people there, and baked together."""
