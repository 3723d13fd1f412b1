"""The benchmark ``plogic bench look-again``."""
