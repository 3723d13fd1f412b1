"""Writing the knowledge bases of towers that are shipped: geometry, junctions and painted textures."""
