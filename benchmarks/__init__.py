"""The project's own benchmarks, peers beside them in the same run.

Outside the wheel; ``plogic bench NAME`` runs them from a checkout.
"""
