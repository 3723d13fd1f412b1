"""The benchmark ``plogic bench sizes``."""
