"""Videos: a child process decodes them, frame by frame and within limits, since they are strangers' files."""
