"""Exact inference on discrete factor graphs: pure numbers, which know nothing of scenes or programs."""
