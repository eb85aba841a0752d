"""The scene as arrays: surfaces, voxels, navmesh, paths and seats. Network frame; independent of Blender."""
