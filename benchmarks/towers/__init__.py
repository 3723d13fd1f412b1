"""The benchmark ``plogic bench towers``."""
