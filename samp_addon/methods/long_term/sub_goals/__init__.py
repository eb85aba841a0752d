"""Sub-goals: what carries a body there, the bodies drawn for it, and how one is fitted to its furniture."""
