"""The ground under a take: treads of stairs, uneven floors, gaps that the body barely fits through."""
