"""The data set: pictures of rooms without people, windows of 65 frames, and which windows a picture may go with.

The corpus' own pictures have a person in them. Here rooms are empty: the character is a condition of the networks, so
that one picture serves every window that begins in view, windows that go on from others, and several characters.
"""
