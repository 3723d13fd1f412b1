"""Files of cameras, poses, moves and meshes, read with care."""
