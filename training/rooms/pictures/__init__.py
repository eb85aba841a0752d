"""Ray-traced pictures of rooms with people: colour, depth, normals and classes, without a display."""
