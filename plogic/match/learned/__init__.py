"""Learned types: one matched keypoint is a whole pose, poses that agree are voted for, the best are refined."""
