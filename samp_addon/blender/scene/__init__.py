"""Reads the artist's scene into the network frame and checks that a take can be made in it."""
