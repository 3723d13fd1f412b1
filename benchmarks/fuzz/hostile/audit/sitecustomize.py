"""Write down what Python opens and starts: read by each Python whose ``PYTHONPATH`` has this folder.

``PLOGIC_AUDIT`` names the file, and ``PLOGIC_AUDIT_KNOWN`` the folders of libraries, of which reading is not told.
Python's own hook tells of it (PEP 578), before it happens, and cannot be taken back by what runs.
"""

import os
import sys

WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
OF_PATHS = {
    "open", "os.listdir", "os.scandir", "os.mkdir", "os.remove", "os.rmdir", "os.rename", "os.symlink", "os.link", "os.chmod", "os.truncate",
    "sqlite3.connect",
}  # fmt: skip
OF_OTHERS = {
    "subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "os.forkpty", "pty.spawn", "socket.connect", "socket.bind",
    "socket.getaddrinfo", "urllib.Request", "webbrowser.open", "syslog.syslog",
}  # fmt: skip
READS = {"os.listdir", "os.scandir"}


def _begin(path: str) -> None:
    known = tuple(filter(None, os.environ.get("PLOGIC_AUDIT_KNOWN", "").split(os.pathsep)))
    log = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)

    def hook(event: str, args: tuple[object, ...]) -> None:
        if event not in OF_PATHS and event not in OF_OTHERS:
            return
        what = os.fsdecode(args[0]) if args and isinstance(args[0], (str, bytes, os.PathLike)) else ""
        if event == "open" and not what:  # of what is open already
            return
        path = os.path.abspath(what) if event in OF_PATHS else what  # noqa: PTH100 - resolve() would open what it follows
        if path.startswith(known) and (
            "__pycache__" in path or event in READS or (event == "open" and not _writes(args))
        ):
            return
        words = args[1] if event == "subprocess.Popen" else ()
        line = " ".join([event, path, *(map(str, words) if isinstance(words, (list, tuple)) else ())])
        os.write(log, line.replace("\n", " ").encode("utf-8", "replace") + b"\n")

    sys.addaudithook(hook)


def _writes(args: tuple[object, ...]) -> bool:
    return len(args) > 2 and isinstance(args[2], int) and bool(args[2] & WRITES)


if os.environ.get("PLOGIC_AUDIT"):
    _begin(os.environ["PLOGIC_AUDIT"])
