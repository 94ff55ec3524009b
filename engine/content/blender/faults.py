# SPDX-License-Identifier: Apache-2.0
"""What ends an export, each kind with an exit code of its own: those that `touchable` has."""


class Fault(Exception):
    """One line for a person: what is wrong, where, and what would be right."""

    code = 1


class BadUsage(Fault):
    """What was asked for cannot be."""

    code = 2


class Refused(Fault):
    """The scene holds what a touchable clip cannot say."""

    code = 3


class NoRenderer(Fault):
    """Blender lacks what the pictures are rendered with, or it failed."""

    code = 4


INTERRUPTED = 130
