"""The ProbLog text that defines what a situation means (§8): ``program_text``."""
