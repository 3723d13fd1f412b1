"""Object types from what others made: robot descriptions (URDF, SDF) and the model folders of BOP."""
