"""Discrete friction problems as files of FCLIB.

FCLIB (Acary, Brémond, Huber 2018, https://github.com/FrictionalContactLibrary) is a collection of
problems with a format in HDF5, which Siconos and other solvers read.
"""

from __future__ import annotations

import os
from typing import Any, Mapping, Optional, Union

import numpy as np

from ._errors import Error

#: The entries of the matrix that are written at a time.
ENTRIES_AT_ONCE = 1 << 24


def require_h5py() -> Any:
    """Returns h5py; says how to get it where it is not."""
    try:
        import h5py
    except ImportError:
        raise ImportError("a file of FCLIB needs h5py: pip install h5py") from None
    return h5py


def write_fclib(
    path: Union[str, os.PathLike[str]], problem: Mapping[str, Any], title: str
) -> None:
    """Writes a problem with its solution; the file takes its place when it is whole."""
    h5py = require_h5py()
    place = os.fspath(path)
    partial = f"{place}.part"
    rows = len(problem["q"])
    try:
        with h5py.File(partial, "w") as file:
            local = file.create_group("fclib_local")
            local["spacedim"] = _int(3)
            _matrix(local.create_group("W"), problem["W"])
            vectors = local.create_group("vectors")
            vectors["q"] = problem["q"]
            vectors["mu"] = np.full(rows // 3, problem["mu"])
            info = local.create_group("info")
            for name, text in (("title", title), ("description", DESCRIPTION)):
                # FCLIB reads texts of a fixed length that end with a zero.
                info[name] = np.bytes_(text.encode("ascii", "replace") + b"\0")
            solution = file.create_group("solution")
            solution["u"], solution["r"] = problem["u"], problem["r"]
        os.replace(partial, place)
    except OSError as error:
        raise Error(f"cannot write {place}: {error}") from error
    finally:
        if os.path.exists(partial):
            os.remove(partial)


DESCRIPTION = (
    "u = W r + q with Coulomb's law, quasi-static. N into the body, x, y of each element. "
    "r [N] is the force of the punch on the foundation, r_N > 0 in compression; u_N [m] is the "
    "gap, u_T [m] the slip of the foundation relative to the punch in the increment; W [m/N]."
)


def _int(value: int) -> Any:
    return np.array([value], dtype=np.int32)


def _matrix(group: Any, matrix: Any) -> None:
    """Writes a full matrix in compressed columns, a few columns at a time."""
    rows, columns = matrix.shape
    entries = rows * columns
    for name, value in (("nzmax", entries), ("m", rows), ("n", columns), ("nz", -1)):
        group[name] = _int(value)
    group["p"] = np.arange(columns + 1, dtype=np.int32) * np.int32(rows)
    indices = group.create_dataset("i", (entries,), dtype=np.int32)
    values = group.create_dataset("x", (entries,), dtype=np.float64)
    at_once = max(1, ENTRIES_AT_ONCE // max(1, rows))
    for first in range(0, columns, at_once):
        last = min(columns, first + at_once)
        place = slice(first * rows, last * rows)
        indices[place] = np.tile(np.arange(rows, dtype=np.int32), last - first)
        values[place] = matrix[:, first:last].T.ravel()


def check_increment(increment: Optional[int]) -> Optional[int]:
    """Refuses what is no number of an increment, before anything is solved."""
    if increment is not None and increment < 1:
        raise Error(f"there is no increment {increment}: increments are counted from 1")
    return increment
