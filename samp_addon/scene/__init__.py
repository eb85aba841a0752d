"""The scene as arrays: surfaces, voxels, navmesh, paths and seats. Network frame; free of Blender."""
