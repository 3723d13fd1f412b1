"""A knowledge base as a folder: its schema, reading it with every mistake at once, and writing it."""
