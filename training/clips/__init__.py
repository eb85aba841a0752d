"""Motion capture files of other people's skeletons to training clips: 22 SMPL-X joints, 30 fps, feet on the floor."""
