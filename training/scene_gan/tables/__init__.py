"""Tables of the paper on the test rooms: Motion FID, non-collision, behaviour, spread over time."""
