"""Compose MotionNet's training sequences from captured clips and furniture."""
