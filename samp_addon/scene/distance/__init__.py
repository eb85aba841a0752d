"""Inside, outside and distance: solid cells, exact surface distances and signed distance fields."""
