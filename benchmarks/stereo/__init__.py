"""The benchmark ``plogic bench stereo``."""
