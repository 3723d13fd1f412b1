"""The benchmark ``plogic bench worlds``."""
