"""Programs come from strangers: two layers between them and the machine (issues 2 and 3).

``allowlist`` names what may be called; ``check`` holds the syntax tree to it, with file, line and column, all mistakes at once; ``engine`` is
ProbLog's engine with every other built-in overridden: it catches what is only built at run time. ``mistakes`` and ``cycle`` tell what goes
wrong in a run. ``child`` runs it all in a process with limits.
"""
