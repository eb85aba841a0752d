"""The data set: pictures of rooms without people, windows of 65 frames, and which windows a picture may go with.

The corpus has a person in each picture. Here people are removed: the character is a condition of the networks, so that
one picture serves every window that begins in view, windows that go on from others, and several characters.
"""
