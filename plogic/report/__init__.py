"""The one-file HTML report of an interpretation."""
