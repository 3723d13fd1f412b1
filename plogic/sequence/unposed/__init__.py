"""Hypotheses whose pose is not known: what detections say of how they occlude, and are occluded (§8, last paragraph)."""
