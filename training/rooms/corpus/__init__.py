"""The corpus on disk: a folder of memory-mapped arrays for each room, lists of windows, and a manifest."""
