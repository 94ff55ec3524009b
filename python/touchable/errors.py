"""What goes wrong, as exceptions: each is a touchable.Error, and what Python programs expect besides."""

from __future__ import annotations

import enum


class Status(enum.IntEnum):
    """The statuses of touchable.h, by name. They have no unit."""

    OK = 0
    INTERNAL = 1  #: a fault of the library
    USAGE = 2  #: an argument cannot be
    INPUT = 3  #: a file, a scene's text or a picture is not what it should be
    STALE = 16  #: the object was closed
    BUSY = 17  #: another thread is using the object, or another object depends on it
    FULL = 18  #: no room for another frame yet; try again once ticks have gone on
    END = 19  #: there are no more frames
    NO_MEMORY = 20  #: there is not enough memory, or there are too many objects
    INTERRUPTED = 130  #: somebody asked to stop


class Error(Exception):
    """What the library refused, in one line: what is wrong, and what would be right.

    Attributes:
        status: a Status, which says of which kind it is.
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
    """The clip, surface or solver was closed: Status.STALE, and a ValueError."""


class MissingFileError(Error, FileNotFoundError):
    """There is no such file: Status.INPUT, and a FileNotFoundError."""


class ExistingFileError(Error, FileExistsError):
    """The file is there already: Status.USAGE, and a FileExistsError. overwrite=True replaces it."""


_kinds: dict[int, type[Error]] = {Status.USAGE: UsageError, Status.STALE: ClosedError}


def error_of(status: int, line: str) -> Error:
    """The exception for a status of the C API and its line. No units."""
    return _kinds.get(status, Error)(status, line)
