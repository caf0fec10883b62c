"""The program ``potamoi``: where it is, and runs of it.

>>> from potamoi import program
>>> program.run("trace", "--scene", "lantern", "--width", "24", "--out", "lantern.npz")   # doctest: +SKIP
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any


class ProgramError(Exception):
    """A run that did not end with exit status 0. ``status`` is its exit status, the text its error."""

    def __init__(self, status: int, message: str) -> None:
        super().__init__(message)
        self.status = status


def path() -> Path:
    """The program: the one that ``POTAMOI`` names, that of the wheel, or the first in ``PATH``.

    Raises:
        FileNotFoundError: There is none, with what to do.
    """
    named = os.environ.get("POTAMOI")
    if named:
        if not os.access(named, os.X_OK):
            raise FileNotFoundError(f"POTAMOI={named}: no program there")
        return Path(named)
    folders = [sysconfig.get_path("scripts"), os.path.join(sys.prefix, "bin")]
    found = shutil.which("potamoi", path=os.pathsep.join(folders)) or shutil.which("potamoi")
    if found:
        return Path(found)
    if sys.platform != "linux":
        raise FileNotFoundError(
            f"the program potamoi runs on Linux, and this is {sys.platform}: run it in a container "
            "(docs/how-to/install.md); the exponential, the reducer and the readers of files work here"
        )
    raise FileNotFoundError("no program potamoi: pip install ./python, or name it in POTAMOI")


def run(*arguments: Any, **options: Any) -> str:
    """Runs a command, and gives what it printed on standard output.

    Args:
        arguments: As on a command line.
        options: Those of :func:`subprocess.run`, such as ``cwd``.

    Raises:
        ProgramError: The exit status is not 0.
        FileNotFoundError: There is no program.
    """
    done = subprocess.run([path(), *map(str, arguments)], text=True, capture_output=True, **options)
    if done.returncode != 0:
        raise ProgramError(done.returncode, done.stderr.strip())
    return done.stdout
