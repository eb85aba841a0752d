"""The corpus on disk: one folder a room with memory-mapped arrays, lists of windows, and a manifest."""
