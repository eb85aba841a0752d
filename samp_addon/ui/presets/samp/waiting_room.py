import bpy

samp = bpy.context.scene.samp
samp.style = 0.1
samp.hold = 10.0
samp.speed = 0.95
samp.samp_posture = {"upright", "hands_on_lap", "legs_crossed"}
