"""Many frames: what they are, who perceives them, and the file of lines that a killed run goes on with."""
