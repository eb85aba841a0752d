import bpy

samp = bpy.context.scene.samp
samp.style = 0.1
samp.hold = 5.0
samp.speed = 0.8
samp.samp_posture = {"lean_back", "hands_on_lap"}
