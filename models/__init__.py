"""The networks (torch) and their weights. Import torch and numpy only."""
