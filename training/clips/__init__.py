"""Import motion capture on any skeleton as training clips: 22 SMPL-X joints, 30 fps, feet on the floor."""
