"""Sub-goals in the scene: arrows that the artist places, and ghost bodies at them."""
