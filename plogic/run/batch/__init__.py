"""Many frames: what they are, who perceives them, and the file of lines, one a frame, that a killed run goes on with."""
