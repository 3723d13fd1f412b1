"""The ProbLog text that defines what a situation means (§8): ``plogic.program.text.program_text``."""
