import bpy

samp = bpy.context.scene.samp
samp.style = 0.1
samp.hold = 1.0
samp.speed = 1.3
samp.samp_posture = set()
