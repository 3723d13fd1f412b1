"""A posed hypothesis judged: Expected, Detected, evidence, rivals, A4."""
