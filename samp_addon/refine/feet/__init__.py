"""The foot lock: where feet stand, and the corrections that keep them there."""
