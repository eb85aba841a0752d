import bpy

samp = bpy.context.scene.samp
samp.style = 0.1
samp.hold = 8.0
samp.speed = 0.9
samp.samp_posture = {"lean_back", "hands_on_armrests"}
