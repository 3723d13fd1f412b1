"""The benchmark ``plogic bench constancy``."""
