"""The benchmark ``plogic bench families``."""
