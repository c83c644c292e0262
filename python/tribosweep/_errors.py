"""The exceptions. Each says what the command would say, in the same words."""

from __future__ import annotations


class Error(Exception):
    """Something that was asked for cannot be done; the words say what and why."""


class StudyError(Error, ValueError):
    """A study or a scene makes no sense.

    The words show each mistake at its place, as the command does; `places` has them as tuples of
    line, column (both counted from 1) and message.
    """

    places: list[tuple[int, int, str]] = []


class QueryError(Error, ValueError):
    """A question to a study cannot be answered: an unknown column, a condition of no meaning."""


class StoreError(Error):
    """A store is not there or cannot be read."""


class RunError(Error, RuntimeError):
    """A run could not go on; what is done is kept."""
