"""Way finding: the walkable surface as convex polygons, and paths over it."""
