"""The rollout of MotionNet: batches of takes, steered along their routes."""
