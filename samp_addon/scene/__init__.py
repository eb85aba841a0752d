"""Scene geometry: voxels, navmesh, path. Arrays in, arrays out; network frame (Y up)."""
