"""SAMP, section 5: what takes measure on furniture and against motion that no training has seen."""
