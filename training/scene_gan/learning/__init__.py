"""Adversarial training: losses, trainer, sheets of samples, and the command for CPU and GPU."""
