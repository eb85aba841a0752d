"""Scene-aware Generative Network (Wang et al. 2021): motion that fits what a camera sees, without a target."""
