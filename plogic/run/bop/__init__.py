"""BOP in and out: datasets of the BOP benchmark, the challenge's results files, its errors and recalls, and simulated scenes as datasets.

Millimetres exist only in the files: what is read is in metres, and what is written is turned back.
"""
