"""The benchmark ``plogic bench attention``."""
