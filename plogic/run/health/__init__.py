"""What is wrong with an installation, its caches and its knowledge bases, and its repair."""
