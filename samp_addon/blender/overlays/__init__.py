"""Goals, way-points, navmesh, path and voxels drawn into the scene, and the preview of a running take."""
