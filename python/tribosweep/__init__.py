"""Parameter studies of elastic contact with Coulomb friction.

`solve` solves one scene in this process; a `Study` is planned and run by worker processes; `open`
reads the results of a store. Everything is in SI units. z points into the foundation, pressure is
positive in compression, forces and moments are the punch's on the foundation.
"""

from ._errors import Error, QueryError, RunError, StoreError, StudyError
from ._result import Figures, Result, solve
from ._store import Store, StoredStudy, open
from ._study import Plan, Run, Study, program

__all__ = [
    "Error",
    "Figures",
    "Plan",
    "QueryError",
    "Result",
    "Run",
    "RunError",
    "Store",
    "StoreError",
    "StoredStudy",
    "Study",
    "StudyError",
    "open",
    "program",
    "solve",
]
