"""One lock for the process's standard streams: libraries that print past Python are diverted, and nothing else is.

What diverts file descriptors 1 and 2 holds the lock, and so does who writes a message: a thread's message would go
where a decoder's complaints go, in another thread.

* ``with DIVERTED: ...``
"""

import os
import threading

DIVERTED = threading.RLock()

if hasattr(os, "register_at_fork"):  # a copy of this process has no thread that could give it back
    os.register_at_fork(before=DIVERTED.acquire, after_in_parent=DIVERTED.release, after_in_child=DIVERTED.release)
