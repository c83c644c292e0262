from os import PathLike
from typing import Any, Optional, Sequence, TypedDict, final

from typing_extensions import NotRequired

__all__ = ["Store", "check", "friction_problem", "path_fields", "solve"]

class _Outline(TypedDict):
    name: str
    question: str
    kind: str
    points: int
    axes: list[str]
    text: str
    files: NotRequired[dict[str, bytes]]

class _Described(TypedDict):
    name: str
    unit: str
    kind: str
    meaning: str

class _Column(TypedDict):
    name: str
    unit: str
    meaning: str
    values: Any
    missing: NotRequired[Any]

class _Solved(TypedDict):
    json: str
    job: str
    columns: list[_Described]
    doubts: list[str]
    fields: Optional[dict[str, Any]]

def check(text: Optional[str], path: str, files: dict[str, bytes]) -> _Outline: ...
def solve(text: Optional[str], path: str, files: dict[str, bytes]) -> _Solved: ...
def path_fields(
    text: Optional[str], path: str, files: dict[str, bytes], job: str
) -> dict[str, Any]: ...
def friction_problem(
    text: Optional[str],
    path: str,
    files: dict[str, bytes],
    job: str,
    increment: Optional[int],
) -> dict[str, Any]: ...
@final
class Store:
    def __new__(cls, directory: str | PathLike[str]) -> Store: ...
    def notes(self) -> list[str]: ...
    def names(self) -> list[str]: ...
    def study(self, name: str) -> _Outline: ...
    def columns(self, name: str, steps: bool) -> list[_Described]: ...
    def table(
        self,
        name: str,
        filter: Optional[str],
        columns: Sequence[str],
        sort: Sequence[str],
        steps: bool,
    ) -> list[_Column]: ...
    def key(self, beginning: str) -> str: ...
    def fields(self, key: str) -> dict[str, Any]: ...
    def path_fields(self, key: str) -> dict[str, Any]: ...
    def friction_problem(self, key: str, increment: Optional[int]) -> dict[str, Any]: ...
    def show(self, key: str) -> str: ...
