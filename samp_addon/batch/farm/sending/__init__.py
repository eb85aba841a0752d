"""A jobs file with all that it needs in one folder, and its way to a render farm."""
