"""The perceptual cycle (figure 1).

Attention, judging, accepting and releasing, its trace, and the facts that a run leaves.
"""
