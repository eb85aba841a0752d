"""Episodes: people who walk about a room, stand, sit and lie, composed from captured clips along navmesh paths."""
