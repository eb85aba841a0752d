"""Which triangles of a scene are one piece of furniture: things resting on it, parts of a joined room."""
