"""A lock between programs, also on other machines: of all that ask for a file, one has it."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

if sys.platform == "win32":
    import msvcrt

    def _take(file: int) -> None:
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)

    def _give_back(file: int, path: str) -> None:
        # An open file cannot be taken away here. One that another has opened since is left to it.
        os.close(file)
        with suppress(OSError):
            os.remove(path)

else:
    import fcntl

    def _take(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _give_back(file: int, path: str) -> None:
        # What cannot be taken away keeps nobody out once it is given back, and the work under it is done.
        try:
            with suppress(OSError):
                os.remove(path)
            # A process that was forked meanwhile has the file open, too.
            with suppress(OSError):
                fcntl.flock(file, fcntl.LOCK_UN)
        finally:
            os.close(file)


HELD = {errno.EAGAIN, errno.EACCES, errno.EDEADLK}
"""What systems say of a file that another has."""

WITHOUT = {getattr(errno, name) for name in ("ENOLCK", "ENOSYS", "ENOTSUP", "EOPNOTSUPP") if hasattr(errno, name)}
"""What file systems without locks say."""


@contextmanager
def locked(path: str) -> Iterator[bool]:
    """Has a file for itself, which is made, and taken away at the end; or says False because another has it.

    The system gives it back where a program is killed: what is left of the file keeps nobody out but other users, who may not open it, and whom a
    PermissionError tells what to do. Where the file system has no locks, nobody is kept out.
    """
    file = _opened(path)
    if file is None:
        yield False
        return
    try:
        yield True
    finally:
        _give_back(file, path)


def _opened(path: str) -> int | None:
    """The file, which nobody else has now; or none."""
    while True:
        try:
            file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        except PermissionError as error:
            # Where there is none, it is the folder that may not be written.
            if not os.path.exists(path):
                raise
            raise PermissionError(f"{path}: left by another user; remove it if no bake is at work") from error
        try:
            _take(file)
        except OSError as error:
            if error.errno not in WITHOUT:
                os.close(file)
                if error.errno in HELD:
                    return None
                raise
        # Who had it may have taken it away since it was opened here, and another have made one anew.
        if _is_at(file, path):
            return file
        os.close(file)


def _is_at(file: int, path: str) -> bool:
    try:
        return os.path.samestat(os.fstat(file), os.stat(path))
    except OSError:
        return False

