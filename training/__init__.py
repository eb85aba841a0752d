"""Data import, augmentation and training; not in the shipped zip."""
