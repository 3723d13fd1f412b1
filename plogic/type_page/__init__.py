"""The one-file HTML page of an object type: its surface, its features and their lobes, in 3D."""
