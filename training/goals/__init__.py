"""GoalNet's labels, training and evaluation."""
