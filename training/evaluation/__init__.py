"""The evaluation of SAMP (section 5): takes on held-out furniture, compared with held-out motion."""
