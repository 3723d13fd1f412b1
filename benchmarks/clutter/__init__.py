"""The benchmark ``plogic bench clutter``."""
