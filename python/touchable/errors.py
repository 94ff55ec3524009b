# SPDX-License-Identifier: Apache-2.0
"""What goes wrong, as exceptions: each is a touchable.Error, and what Python programs expect besides."""

from __future__ import annotations

import enum


class Status(enum.IntEnum):
    """How a call of the library went, by the names of touchable.h. Numbers without a unit.

    OK: done; nothing raises it.
    INTERNAL: a fault of the library.
    USAGE: an argument cannot be.
    INPUT: a file, a scene's text or a picture is not what it should be.
    STALE: the object was closed.
    BUSY: another thread is using the object, or another object depends on it.
    FULL: no room for another frame yet; try again once ticks have gone on.
    END: there are no more frames; a loop ends then.
    NO_MEMORY: there is not enough memory, or there are too many objects.
    FORKED: the object belongs to the parent process.
    EXISTS: a file of that name exists, and may not be replaced.
    INTERRUPTED: somebody asked to stop.
    """

    OK = 0
    INTERNAL = 1
    USAGE = 2
    INPUT = 3
    STALE = 16
    BUSY = 17
    FULL = 18
    END = 19
    NO_MEMORY = 20
    FORKED = 21
    EXISTS = 22
    INTERRUPTED = 130


class Error(Exception):
    """What the library refused, in one line: what is wrong, and what would be right.

    status: a Status, which says of which kind it is.
    line: the line, as str() gives it.
    """

    status: Status

    def __init__(self, status: int, line: str) -> None:
        super().__init__(line)
        self.status = Status(status) if status in Status._value2member_map_ else Status.INTERNAL
        self.line = line

    def __str__(self) -> str:
        return self.line

    def __reduce__(self) -> tuple:
        return type(self), (int(self.status), self.line)


class UsageError(Error, ValueError):
    """An argument cannot be: Status.USAGE, and a ValueError."""


class ClosedError(Error, ValueError):
    """The clip, surface or solver was closed (Status.STALE), or belongs to the process from which this one was forked
    (Status.FORKED); and a ValueError."""


class MissingFileError(Error, FileNotFoundError):
    """There is no such file: Status.INPUT, and a FileNotFoundError."""


class ExistingFileError(Error, FileExistsError):
    """The file is there already: Status.EXISTS, and a FileExistsError. overwrite=True replaces it."""


_kinds: dict[int, type[Error]] = {Status.USAGE: UsageError, Status.STALE: ClosedError, Status.FORKED: ClosedError,
                                  Status.EXISTS: ExistingFileError}


def error_of(status: int, line: str) -> Error:
    """The exception for a status of the C API and its line. No units."""
    return _kinds.get(status, Error)(status, line)
