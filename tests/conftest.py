"""What holds for all tests: one thread for products of matrices, and ProbLog without its warnings.

As the commands do (``cli.main``), numpy's library is told to use one thread: our products are many and small, and two
workers whose threads wait for each other take a third longer. ProbLog brings an old pyparsing, which is imported once,
its deprecation warnings aside.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from plogic.logic.safety.author import load_problog

load_problog()
