"""The benchmark ``plogic bench programs``."""
