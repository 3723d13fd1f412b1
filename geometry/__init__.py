"""Where things are: frames, cameras, poses, visibility, outlines, overlap. Knows no object types and no beliefs."""
