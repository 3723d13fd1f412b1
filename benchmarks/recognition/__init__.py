"""The benchmark ``plogic bench recognition``."""
