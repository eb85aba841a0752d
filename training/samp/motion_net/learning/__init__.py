"""MotionNet's training: frames resident on the device, rollouts in flight, optimiser steps (section 3.4)."""
