"""The data set: pictures of empty rooms, windows of 65 frames, and the pairs of a picture with windows in view.

The corpus' own pictures show a person. Here rooms are empty: the character is a condition of the networks, so that one
picture serves all windows that begin in view, windows that continue others, and several characters.
"""
