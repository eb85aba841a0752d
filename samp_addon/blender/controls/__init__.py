"""Controls of hands and feet over whatever take a human plays, from Blender's own parts."""
