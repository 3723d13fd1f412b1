"""The benchmark ``plogic bench panorama``."""
