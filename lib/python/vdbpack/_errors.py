"""The exceptions and the warning of the package."""

from __future__ import annotations

import sys
import warnings

__all__ = ["Error", "ParameterError", "InputError", "FileError", "ResourceError", "VdbpackWarning"]


class Error(Exception):
    """Base of all exceptions of the package."""


class ParameterError(Error, ValueError):
    """An argument cannot be used: a name, a value or a combination."""


class InputError(Error, ValueError):
    """The content of a file or an array cannot be used, such as a mesh with holes."""


class FileError(Error, OSError):
    """A file cannot be read or written."""


class ResourceError(Error, MemoryError):
    """Memory, threads or disk space do not suffice."""


class VdbpackWarning(UserWarning):
    """Something in the input or the result that should be looked at."""


def warn(text: str) -> None:
    """Warns at the line that called the package."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back and frame.f_globals.get("__name__", "").startswith(__package__ + "."):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, VdbpackWarning, stacklevel=level)
