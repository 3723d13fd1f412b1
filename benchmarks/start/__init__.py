"""The benchmark ``plogic bench start``."""
