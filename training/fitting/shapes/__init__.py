"""What fitting looks at: pieces, the surfaces of seats, depths both ways, points of the body and changes of it."""
