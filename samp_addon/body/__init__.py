"""The default human and its skinning."""
