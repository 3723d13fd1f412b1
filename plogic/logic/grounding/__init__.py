"""From texts, goals and evidence to the ground program."""
