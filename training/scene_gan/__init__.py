"""Training of Scene GAN: data, encoder, adversarial training, and the tables of the paper."""
