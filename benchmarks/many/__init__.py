"""The benchmark ``plogic bench many``."""
