"""The project's own benchmarks: each prints its table and ends with its claims."""
