import bpy

samp = bpy.context.scene.samp
samp.style = 0.1
samp.hold = 6.0
samp.speed = 1.0
samp.samp_posture = {"upright", "hands_on_table"}
