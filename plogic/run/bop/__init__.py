"""BOP in and out: datasets, the challenge's results files, errors and recalls, simulated scenes as datasets.

Millimetres exist only in the files: what is read is in metres, and what is written is turned back.
"""
