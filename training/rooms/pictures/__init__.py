"""Pictures of rooms with people by ray tracing: colour, depth, normals and classes, without a screen."""
