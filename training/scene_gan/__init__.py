"""Training of Scene GAN: data, the encoder, the adversarial training, and the tables of the paper."""
