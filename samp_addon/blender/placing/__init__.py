"""Places that an artist aims at: read from the scene, drawn while the mouse moves, and lines drawn on the floor."""
