"""Stores, read beside whatever run is writing them."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np
import pandas as pd

from . import _native
from ._fclib import check_increment, require_h5py, write_fclib
from ._fields import dataset
from ._html import table

#: The store where none is named.
USUAL_STORE = ".tribosweep"


def usual_store(store: Union[str, os.PathLike[str], None]) -> str:
    """Returns the path of a store: what is given, else what TRIBOSWEEP_STORE says."""
    return os.fspath(store or os.environ.get("TRIBOSWEEP_STORE") or USUAL_STORE)


def open(store: Union[str, os.PathLike[str], None] = None) -> Store:
    """Opens a store for reading, or a directory of exports.

    Without an argument that is the store of the command: TRIBOSWEEP_STORE, or `.tribosweep`. It
    never writes there and holds up no run: what it reads comes from the process that writes the
    store, or from a private copy of the records. Each question is answered from what is there when
    it is asked, also in a process that was forked.

    Raises `StoreError` if there is none.

    The examples are of a store in which the example of `Study` has run:

    >>> import tribosweep
    >>> store = tribosweep.open()
    >>> list(store)
    ['stick-zone-of-a-coating']
    >>> store["stick-zone-of-a-coating"]
    <tribosweep.StoredStudy stick-zone-of-a-coating: 2 points over mu>
    """
    return Store(usual_store(store))


class Store(Mapping):
    """The studies of a store by name."""

    def __init__(self, path: str) -> None:
        self.path = path
        # The directory may be left before the next question.
        self._native = _native.Store(os.path.abspath(path))

    @property
    def notes(self) -> list[str]:
        """What is to be said of the place from which records are read, in words."""
        return self._native.notes()

    def __getitem__(self, name: str) -> StoredStudy:
        if name not in self:
            # A dictionary says which key is missing; a store says which there are.
            listed = ", ".join(self) or "none so far"
            raise KeyError(f"there is no study `{name}` in the store; it has {listed}")
        return StoredStudy(self, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._native.names())

    def __len__(self) -> int:
        return len(self._native.names())

    def __contains__(self, name: object) -> bool:
        return name in self._native.names()

    def arrays(self, key: str, steps: bool = False) -> dict[str, np.ndarray]:
        """Returns the fields of a result by the beginning of its key, by name, shape (y, x).

        With `steps` they are those of all increments, shape (increment, y, x). A store has those
        of the last one only, so the path is solved again, and each increment has to have the very
        figures of the record.
        """
        if steps:
            return self._native.path_fields(key)
        return {
            name: values
            for name, values in self._native.fields(key).items()
            if isinstance(values, np.ndarray)
        }

    def fields(self, key: str, steps: bool = False) -> Any:
        """Returns the fields of a result by the beginning of its key, as an xarray.Dataset.

        `attrs` have the `key` in full and `certified`: 0 if they are those of a last iterate. With
        `steps` there is a dimension `increment`, counted from 1, as `arrays` has it.

        >>> import tribosweep
        >>> store = tribosweep.open()
        >>> key = store["stick-zone-of-a-coating"].query(select="key").key[0]
        >>> fields = store.fields(key[:12])
        >>> dict(fields.sizes), fields.pressure.attrs["units"], fields.attrs["certified"]
        ({'y': 16, 'x': 16}, 'Pa', 1)
        """
        found = self._native.fields(key)
        attributes = {"key": found["key"], "certified": int(found["certified"])}
        return dataset(self._native.path_fields(key) if steps else found, attributes)

    def problem(self, key: str, increment: Optional[int] = None) -> dict[str, Any]:
        """Returns the discrete friction problem of a result, as `Result.problem` describes it.

        The path is solved again, and each increment has to have the very figures of the record.
        """
        check_increment(increment)
        return self._native.friction_problem(key, increment)

    def fclib(
        self, key: str, path: Union[str, os.PathLike[str]], increment: Optional[int] = None
    ) -> None:
        """Writes the discrete friction problem of a result as a file of FCLIB, with h5py.

        `Result.fclib` says what is in it.
        """
        require_h5py()
        write_fclib(path, self.problem(key, increment), f"job {self._native.key(key)}")

    def show(self, key: str) -> dict[str, Any]:
        """Returns everything about a result by the beginning of its key, in SI units."""
        return json.loads(self._native.show(key))

    def __repr__(self) -> str:
        return f"<tribosweep.Store {self.path}: {', '.join(self) or 'no studies so far'}>"

    def _repr_html_(self) -> str:
        studies = ((name, self[name].question) for name in self)
        return table(f"store {self.path}", studies)


class StoredStudy:
    """A study in a store, whatever of it has been computed so far.

    Its attributes are those of the moment at which it was looked up; what its methods return is
    read anew each time.
    """

    def __init__(self, store: Store, name: str) -> None:
        self._store = store
        self._outline = store._native.study(name)
        self.name = name
        self.question: str = self._outline["question"]
        self.kind: str = self._outline["kind"]
        #: The number of points that the axes make.
        self.points: int = self._outline["points"]
        #: The names of the axes' columns.
        self.axes: list[str] = self._outline["axes"]
        #: The text of the study file.
        self.text: str = self._outline["text"]

    def columns(self, steps: bool = False) -> pd.DataFrame:
        """Returns every column that can be selected, with its unit, kind and meaning."""
        listed = self._store._native.columns(self.name, steps)
        return pd.DataFrame(listed).set_index("name")

    def query(
        self,
        where: Optional[str] = None,
        select: Union[str, Sequence[str], None] = None,
        sort: Union[str, Sequence[str], None] = None,
        steps: bool = False,
    ) -> pd.DataFrame:
        """Returns results as a DataFrame in SI units, a row for each point.

        The arguments are those of `tribosweep query`: `where="mu > 0.3 && mesh == 32"`,
        `select=["mu", "load"]` (else the axes and the usual figures), `sort="-load"`, and `steps`
        for a row of each increment of the loading paths. `attrs["units"]` and
        `attrs["meanings"]` say what the columns are.

        Raises `QueryError` for a column or a condition that makes no sense.

        >>> import tribosweep
        >>> results = tribosweep.open()["stick-zone-of-a-coating"]
        >>> frame = results.query("mu > 0.3", select=["mu", "load"])
        >>> list(frame.mu), frame.attrs["units"]["load"]
        ([0.4], 'N')
        """
        table = self._table(where, select, sort, steps)
        frame = pd.DataFrame({column["name"]: _values(column) for column in table})
        frame.attrs = {
            "study": self.name,
            "units": {column["name"]: column["unit"] for column in table},
            "meanings": {column["name"]: column["meaning"] for column in table},
        }
        return frame

    def arrow(
        self,
        where: Optional[str] = None,
        select: Union[str, Sequence[str], None] = None,
        sort: Union[str, Sequence[str], None] = None,
        steps: bool = False,
    ) -> Any:
        """Returns the same as `query` as a pyarrow.Table; each field has its unit and meaning.

        What is missing is null.

        >>> import tribosweep
        >>> table = tribosweep.open()["stick-zone-of-a-coating"].arrow(select="mu,load", sort="mu")
        >>> table.column("mu").to_pylist(), table.schema.field("load").metadata[b"unit"]
        ([0.2, 0.4], b'N')
        """
        try:
            import pyarrow
        except ImportError:
            raise ImportError("a table of Arrow needs pyarrow: pip install pyarrow") from None
        arrays, fields = [], []
        for column in self._table(where, select, sort, steps):
            array = pyarrow.array(column["values"], mask=column.get("missing"))
            # A column without any value has no type of its own.
            if isinstance(column["values"], list):
                array = array.cast(pyarrow.string())
            said = {"unit": column["unit"], "meaning": column["meaning"]}
            arrays.append(array)
            fields.append(pyarrow.field(column["name"], array.type, metadata=said))
        return pyarrow.table(arrays, schema=pyarrow.schema(fields, {"study": self.name}))

    def fields(self, key: str, steps: bool = False) -> Any:
        """Returns the fields of a result by the beginning of its key, as `Store.fields` does."""
        return self._store.fields(key, steps)

    def _table(
        self,
        where: Optional[str],
        select: Union[str, Sequence[str], None],
        sort: Union[str, Sequence[str], None],
        steps: bool,
    ) -> Any:
        return self._store._native.table(self.name, where, _names(select), _names(sort), steps)

    def __repr__(self) -> str:
        axes = ", ".join(self.axes) or "no axes"
        return f"<tribosweep.StoredStudy {self.name}: {self.points} points over {axes}>"

    def _repr_html_(self) -> str:
        rows = [("question", self.question), ("kind", self.kind), ("points", self.points)]
        return table(self.name, [*rows, ("axes", ", ".join(self.axes))])


def _names(names: Union[str, Sequence[str], None]) -> list[str]:
    if isinstance(names, str):
        return [name.strip() for name in names.split(",")]
    return list(names or [])


def _values(column: Any) -> Any:
    values, missing = column["values"], column.get("missing")
    if isinstance(values, list):
        return pd.Series(values, dtype=object)
    # A missing number is NaN already.
    if values.dtype.kind == "f" or not missing.any():
        return values
    array = pd.arrays.BooleanArray if values.dtype.kind == "b" else pd.arrays.IntegerArray
    return array(values, missing)
