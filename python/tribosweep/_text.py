"""Studies that are dictionaries, as the text of a study file."""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
import re
from typing import Any, Mapping

import numpy as np

_BARE = re.compile(r"[A-Za-z0-9_-]+\Z")


class _Writer:
    """Writes TOML, and takes out the arrays that stand for files."""

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}

    def table(self, table: Mapping[str, Any], path: str = "") -> str:
        """Returns the lines of a table: values first, then the tables below it."""
        lines, below = [], []
        for name, value in table.items():
            key = _key(name, path)
            full = f"{path}.{key}" if path else key
            if path == "" and isinstance(value, Mapping):
                below.append(f"\n[{full}]\n{self.table(value, full)}")
            else:
                lines.append(f"{key} = {self.value(value, full)}\n")
        return "".join(lines + below)

    def value(self, value: Any, path: str) -> str:
        if isinstance(value, np.ndarray) and value.ndim == 2 and path.endswith(".file"):
            return _text(self.file(value))
        if isinstance(value, (np.generic, np.ndarray)):
            value = value.tolist()
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, int):
            return str(value)
        if isinstance(value, float):
            return repr(value) if math.isfinite(value) else str(value)
        if isinstance(value, (str, os.PathLike)):
            return _text(os.fspath(value))
        if isinstance(value, Mapping):
            keys = ((_key(name, path), item) for name, item in value.items())
            items = (f"{key} = {self.value(item, f'{path}.{key}')}" for key, item in keys)
            return "{ " + ", ".join(items) + " }"
        if isinstance(value, (list, tuple, range)):
            return "[" + ", ".join(self.value(item, path) for item in value) + "]"
        raise TypeError(
            f"{path}: {type(value).__name__} has no form in a study; numbers, texts, lists, "
            "dictionaries and arrays have"
        )

    def file(self, heights: np.ndarray) -> str:
        """Keeps an array of heights as an NPY file and returns its name, which tells its contents:
        no file that a study names beside it has the same one.
        """
        bytes_ = io.BytesIO()
        np.save(bytes_, np.ascontiguousarray(heights, dtype=np.float64), allow_pickle=False)
        name = f"array-{hashlib.sha256(bytes_.getvalue()).hexdigest()[:32]}.npy"
        self.files[name] = bytes_.getvalue()
        return name


def _key(name: Any, path: str) -> str:
    """Returns a key below a path, whose dots lead into tables as they do in a file."""
    if not isinstance(name, str):
        raise TypeError(f"{path or 'the study'}: a key must be a text, not {name!r}")
    return name if all(_BARE.match(part) for part in name.split(".")) else _text(name)


def _text(text: str) -> str:
    # JSON escapes what TOML does, except for the character of deletion.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def study_text(study: Mapping[str, Any]) -> tuple[str, dict[str, bytes]]:
    """Returns a study as the text of its file, and the files that its arrays make."""
    writer = _Writer()
    return writer.table(study), writer.files
