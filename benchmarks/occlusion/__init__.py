"""The benchmark ``plogic bench occlusion``."""
