"""The benchmark ``plogic bench calibration``."""
