"""The simulated camera: meshes, poses and textures go in, pixels come out. It knows no object type."""
