"""The control rig of a human: IK controls of hands and feet, made of Blender's own constraints, above any take."""
