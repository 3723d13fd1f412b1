"""The benchmark ``plogic bench scale``."""
