"""Answers from the circuit: probabilities, intervals by a deadline, ranked states."""
