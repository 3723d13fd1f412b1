"""The benchmark ``plogic bench batch``."""
