"""The scene as arrays: surfaces, voxels, the navmesh, paths and seats. Network frame; nothing here knows Blender."""
