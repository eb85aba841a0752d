"""Uses of furniture: sits and lies in the frame of a piece, composed, fitted, or read from a file."""
