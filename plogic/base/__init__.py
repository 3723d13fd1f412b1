"""What every floor uses: errors, clocks and deadlines, caches, child processes, bounds that ProbLog can read."""
