"""The tables of the paper on the test rooms: Motion FID, non-collision, shares of behaviour, spread over time."""
