"""The shell at a pseudo-terminal: type keys, wait for what they bring."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import termios
import time

from console import BIN

SECONDS = 30
"""How long a text may take to appear."""


class Terminal:
    """A running shell; ``screen`` is everything it wrote, without escape sequences."""

    def __init__(self, *args, **env):
        self.master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 110, 0, 0))
        variables = (
            {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "PLOGIC_TRACEBACK")} | {"TERM": "xterm"} | env
        )
        command = ["setsid", "--ctty", "--wait", str(BIN / "plogic"), "shell", *map(str, args)]
        self.process = subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, env=variables)
        os.close(slave)
        self.raw = b""

    @property
    def screen(self):
        """What was written since the last keys."""
        plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", self.raw.decode(errors="replace"))
        return plain.replace("\r", "")

    def type(self, keys):
        """Press keys, and forget what was on the screen."""
        self.raw = b""
        os.write(self.master, keys.encode())

    def wait(self, pattern):
        """Read until a regular expression is on the screen; its text."""
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            found = re.search(pattern, self.screen)
            if found:
                return found.group()
            self._read(0.2)
        raise AssertionError(f"{pattern!r} did not come; there is: {self.screen!r}")

    def leave_alone(self, seconds):
        """Let a question be at work: Ctrl-C is a key of the prompt until it is."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._read(0.1)

    def _read(self, seconds):
        if not select.select([self.master], [], [], seconds)[0]:
            return
        try:
            data = os.read(self.master, 65536)
        except OSError:  # the other side is closed
            return
        if b"\x1b[6n" in data:
            os.write(self.master, b"\x1b[1;1R")  # where the cursor is, as a terminal answers
        self.raw += data

    def end(self):
        """The exit code, once the shell has ended by itself."""
        end = time.monotonic() + SECONDS
        while self.process.poll() is None and time.monotonic() < end:
            self._read(0.1)
        os.close(self.master)
        return self.process.wait(1)

    def kill(self):
        """End it, if it has not ended."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
