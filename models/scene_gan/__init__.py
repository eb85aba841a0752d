"""The networks of "Scene-aware Generative Network for Human Motion Synthesis" (Wang et al. 2021).

Lengths are in metres, at 30 frames per second. All motion is in the *view frame*: the network frame (Y up) with its
origin in the camera and its Z axis along the camera's horizontal viewing direction, so X points to the left of the
picture. The paper uses the camera's own axes; here the camera's pitch and roll are known and need not be learnt.
"""
