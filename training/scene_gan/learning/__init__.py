"""Adversarial training: losses, the trainer, sheets of samples, the command for CPU and for a GPU."""
