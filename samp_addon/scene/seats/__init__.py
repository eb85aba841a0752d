"""Places where a body can sit or lie, found from geometry alone."""
