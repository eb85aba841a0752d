"""The networks and their weights. Imports torch and numpy only."""
