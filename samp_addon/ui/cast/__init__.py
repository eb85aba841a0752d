"""The cast in the sidebar: its settings, its list, and the cast of the selection."""
