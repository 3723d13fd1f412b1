"""The benchmark ``plogic bench box``."""
