"""The benchmark ``plogic bench places``."""
