"""Small tables for notebooks."""

from __future__ import annotations

import html
from typing import Any, Iterable, Sequence


def shown(value: Any) -> str:
    """Returns a value as it is read: six digits of a number."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def table(caption: str, rows: Iterable[Sequence[Any]]) -> str:
    """Returns a table whose first column names its rows."""
    lines = [f"<table><caption>{html.escape(caption)}</caption>"]
    for name, *values in rows:
        cells = "".join(f"<td>{html.escape(shown(value))}</td>" for value in values)
        lines.append(f'<tr><th style="text-align:left">{html.escape(str(name))}</th>{cells}</tr>')
    return "".join(lines) + "</table>"
