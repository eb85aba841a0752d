"""Training and evaluation of GoalNet."""
