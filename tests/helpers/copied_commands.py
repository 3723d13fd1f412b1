"""Runs commands for ``console``: each in a copy (fork) of this process, which has imported everything and run nothing.

A copy is a process like any other, with its own folder, environment, descriptors and exit status; only the second that
imports take is spared. Requests come on stdin, one JSON object a line; for each, the copy's id and then its exit status
(negative: the signal) are written to stdout.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import json
import os
import pkgutil
import runpy
import sys
import threading
import traceback
import warnings
from contextlib import suppress
from pathlib import Path

PACKAGES = "geometry", "kb", "sensing", "plogic"
OTHERS = "trimesh", "embreex.mesh_construction", "embreex.rtcore", "embreex.rtcore_scene", "manifold3d", "rich.console"
"""Imported by functions of ours, when they are called."""
LEARNING = "kb.learning.", "plogic.face.authoring.", "cli."
"""What a start of one's own may change, and who imports it."""
ASIDE = "plogic.logic."
"""Imported and put aside: ProbLog, which they bring, sets the limit of recursion, and most commands do without."""


def import_all():
    """Import whatever a command may; numpy is told first what ``cli`` would tell it."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # pybullet's
        for package in map(importlib.import_module, PACKAGES):
            for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
                if not module.name.startswith(ASIDE):
                    import_one(module.name)
        for name in ("cli", *OTHERS):
            importlib.import_module(name)
        assert "problog" not in sys.modules, "it would change what commands do that do without"
        sys.meta_path.insert(0, Aside())
        assert "problog" not in sys.modules
    gc.collect()
    gc.freeze()  # a copy's collector would write to, and so copy, the memory of what is imported


class Aside:
    """Finds modules that were imported before and are not in ``sys.modules``: an import of one finds it ready."""

    def __init__(self):
        before, limit = dict(sys.modules), sys.getrecursionlimit()
        for module in pkgutil.walk_packages(sys.modules["plogic.logic"].__path__, ASIDE):
            if not module.name.endswith("program_child"):
                importlib.import_module(module.name)
        self.limit, new = sys.getrecursionlimit(), sys.modules.keys() - before.keys()
        sys.setrecursionlimit(limit)
        self.modules = {name: sys.modules.pop(name) for name in new if name.startswith((ASIDE, "problog", "pysdd"))}

    def find_spec(self, name, *_):
        """The spec of a module that was put aside."""
        if name not in self.modules:
            return None
        spec = self.modules[name].__spec__
        spec.loader = self
        return spec

    def create_module(self, spec):
        """The module, as it is."""
        return self.modules[spec.name]

    def exec_module(self, module):
        """Set what ProbLog sets outside of itself."""
        if module.__name__ == "problog":
            sys.setrecursionlimit(self.limit)
            self.modules["problog.setup"].set_environment()


def import_one(name):
    """Import a module of ours, if what it needs of others is there: there are Pythons without pybullet."""
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as missing:
        if missing.name.split(".")[0] in (*PACKAGES, "cli"):
            raise


def serve():
    """Answer requests until there are no more; returns in each copy, which has become what its request says."""
    requests, answers = os.fdopen(os.dup(0)), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)
    for line in requests:
        copy = os.fork()
        if not copy:
            become(json.loads(line))
            return
        os.write(answers, f"{copy}\n".encode())
        os.write(answers, f"{os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1])}\n".encode())
    sys.exit()


def become(request):
    """Take over the folder, the environment, the arguments and the three streams; nothing else stays open."""
    os.setsid()
    os.closerange(3, 256)
    os.chdir(request["cwd"])
    os.environ.clear()
    os.environ.update(request["environment"])
    for number, (name, mode) in enumerate((("stdin", os.O_RDONLY), ("stdout", os.O_WRONLY), ("stderr", os.O_WRONLY))):
        stream = os.open(Path(request["streams"]) / name, mode)
        os.dup2(stream, number)
        os.close(stream)
    sys.argv = request["command"]
    start = Path(request["environment"].get("PYTHONPATH", "")) / "sitecustomize.py"
    if start.is_file():  # which Python would have run as it started, before what it changes is imported
        for name in [name for name in sys.modules if f"{name}.".startswith(LEARNING)]:
            del sys.modules[name]
        sys.path.insert(0, str(start.parent))
        runpy.run_path(str(start))


def run():
    """The exit status of the command, as Python would give it."""
    from cli import main

    try:
        main()
    except SystemExit as left:
        if left.code is None or isinstance(left.code, int):
            return left.code or 0
        sys.stderr.write(f"{left.code}\n")
        return 1
    except BaseException:  # noqa: BLE001 - as any process does that is not told otherwise
        traceback.print_exc()
        return 1
    return 0


def end(status):
    """End the process without taking the imported modules apart, which takes longer than most commands."""
    threading._shutdown()
    atexit._run_exitfuncs()
    with suppress(OSError, ValueError):  # a command may have closed them
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(status & 0xFF)


if __name__ == "__main__":
    sys.path.pop(0)  # this file's folder: a console script's is no package's either
    import_all()
    serve()
    end(run())
