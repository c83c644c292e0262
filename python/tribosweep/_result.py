"""One scene, solved in this process."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from typing import Any, Optional, Union

import numpy as np

from . import _native
from ._fclib import check_increment, require_h5py, write_fclib
from ._fields import UNITS, dataset
from ._html import shown, table
from ._text import study_text

Scene = Union[str, "os.PathLike[str]", Mapping[str, Any]]
#: The text of a study or None, the path that messages name, and the files in it.
Source = tuple[Optional[str], str, dict[str, bytes]]

#: The tables of a study that stand beside its scene and ask for more results of it.
BESIDE_SCENE = ("interior",)


class Figures(Mapping):
    """Figures by name, also as attributes, with their units and meanings."""

    def __init__(self, figures: dict[str, Any], columns: list[Any]) -> None:
        self._figures = figures
        self.units: dict[str, str] = {column["name"]: column["unit"] for column in columns}
        self.meanings: dict[str, str] = {column["name"]: column["meaning"] for column in columns}

    def __getitem__(self, name: str) -> Any:
        if name in self.units:
            return self._figures.get(name)
        raise KeyError(name)

    def __getattr__(self, name: str) -> Any:
        if name in self.__dict__.get("units", {}):
            return self._figures.get(name)
        raise AttributeError(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._figures)

    def __len__(self) -> int:
        return len(self._figures)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.units]

    def __repr__(self) -> str:
        lines = (f"{name} = {shown(self[name])} {self.units[name]}".rstrip() for name in self)
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = ((name, self[name], self.units[name], self.meanings[name]) for name in self)
        return table("", rows)


class Result:
    """The result of a scene.

    Every figure that `tribosweep query` has of a result is an attribute, such as `load` [N],
    `peak_pressure` [Pa] or `contact_area` [m²], and None where it is missing; `units` and
    `meanings` say what each is. The settings are no figures: `job` has them. `observables`, `certificate` (0 is exact) and `estimates` (of the
    discretisation error, relative) have them by kind. The fields are arrays of shape (y, x):
    `pressure`, `traction_x`, `traction_y` [Pa], `gap`, `slip_x`, `slip_y` [m] and `state`
    (0 outside, 1 open, 2 stick, 3 slip) and `friction_work` [J/m²], over the centres of the
    elements `x` and `y` [m]. A scene that wears has the field `wear_depth` [m] too, in `arrays()`
    and `fields()`; the attribute `wear_depth` is the figure, the largest depth. Of a result that is not `certified` the figures
    of the solution are None, the arrays are those of the last iterate, and `warnings` say why.

    >>> import tribosweep
    >>> result = tribosweep.solve(
    ...     foundation={"base": {"shear_modulus": "80 GPa", "poisson": 0.3}},
    ...     punch={"shape": "sphere", "radius": "50 mm"},
    ...     loading={"steps": [{"normal_force": "1 kN"}]},
    ...     numerics={"mesh": 32},
    ... )
    >>> result.certified, round(result.load)
    (True, 1000)
    >>> result.pressure.shape, bool(result.pressure.max() == result.peak_pressure)
    ((32, 32), True)
    """

    def __init__(self, solved: Any, source: Source) -> None:
        # What the path is solved from again, where more of it is asked for.
        self._source = (*source, solved["job"])
        #: Everything that `tribosweep solve --json` prints.
        self.json: dict[str, Any] = json.loads(solved["json"])
        #: What is to be doubted, in words.
        self.warnings: list[str] = solved["doubts"]
        columns = [column for column in solved["columns"] if column["kind"] != "key"]
        self._all = Figures(self.json["result"], columns)
        self._fields: Optional[dict[str, np.ndarray]] = solved["fields"]

        def of_kind(kind: str) -> Figures:
            chosen = [column for column in columns if column["kind"] == kind]
            names = (column["name"] for column in chosen)
            known = self.json["result"]
            return Figures({name: known[name] for name in names if name in known}, chosen)

        self.observables = of_kind("observable")
        self.certificate = of_kind("certificate")
        self.estimates = of_kind("error")
        self.units: dict[str, str] = {**self._all.units, **UNITS}
        self.meanings: dict[str, str] = self._all.meanings

    @property
    def certified(self) -> bool:
        """Whether the certificate meets the tolerance."""
        return self.json["result"]["status"] == "certified"

    @property
    def job(self) -> dict[str, Any]:
        """The job in SI units, as it stands under its key."""
        return self.json["job"]

    @property
    def planes(self) -> list[dict[str, float]]:
        """The largest stresses on every plane that `[interior]` asks for, from the surface down."""
        return self.json.get("planes", {}).get("rows", [])

    @property
    def points(self) -> list[dict[str, float]]:
        """The stress at every point that `[interior]` asks for, in the order of the study."""
        return self.json.get("points", {}).get("rows", [])

    @property
    def provenance(self) -> dict[str, Any]:
        """What computed it: program, machine, command line, and digests of the study's files."""
        return self.json["provenance"]

    def arrays(self, steps: bool = False) -> dict[str, np.ndarray]:
        """Returns the fields and their coordinates by name.

        With `steps` they are those of all increments, shape (increment, y, x), for which the path
        is solved again.
        """
        if steps:
            return _native.path_fields(*self._source)
        if self._fields is None:
            raise AttributeError("this kind of study leaves no fields")
        return self._fields

    def fields(self, steps: bool = False) -> Any:
        """Returns the fields as an xarray.Dataset, where xarray is present.

        With `steps` it has a dimension `increment`, counted from 1; the path is solved again.
        """
        return dataset(self.arrays(steps), {"key": self.key, "status": self.status})

    def problem(self, increment: Optional[int] = None) -> dict[str, Any]:
        """Returns the discrete friction problem of an increment, the last one by default.

        The problem is u = W r + q over the n elements under the punch's sole, with Coulomb's law
        and the friction coefficient `mu`. Vectors have 3n entries, (N, x, y) of each element after
        the other; `elements` has the elements' indices in the fields, row by row.

        - `r` [N] are the forces of the punch on the foundation: the tractions times the area of an
          element. r_N is positive in compression.
        - `u` [m] are the gap u_N ≥ 0 and the slip u_T of the foundation relative to the punch since
          the increment before. Where there is slip, r_T = −μ r_N u_T/‖u_T‖. Without friction r_T
          is 0, and u_T, on which nothing depends, counts from the beginning of the path.
        - `W` [m/N] are the elements' compliances, over their area, with ε on the diagonal where
          `epsilon` is given; it is symmetric and full, and refused beyond 4 GiB (a full square of
          87 × 87 elements).
        - `q` [m] are gap and slip as they would be without any force, at the motion of the punch
          that the solution has, also where forces govern it.

        De Saxcé's change of variable, u_N + μ‖u_T‖, is the solver's matter and not in it. The path
        is solved again up to the increment, whose number counts from 1.

        >>> import tribosweep
        >>> result = tribosweep.solve(
        ...     foundation={"base": {"shear_modulus": "80 GPa", "poisson": 0.3}},
        ...     punch={"shape": "sphere", "radius": "50 mm"},
        ...     friction={"mu": 0.3},
        ...     loading={"steps": [{"approach": "20 um", "shift_x": "2 um"}]},
        ...     numerics={"mesh": 8},
        ... )
        >>> problem = result.problem()
        >>> problem["W"].shape
        (192, 192)
        >>> bool(abs(problem["r"][0::3].sum() / result.load - 1) < 1e-12)
        True
        """
        check_increment(increment)
        return _native.friction_problem(*self._source, increment)

    def fclib(
        self, path: Union[str, os.PathLike[str]], increment: Optional[int] = None
    ) -> None:
        """Writes the discrete friction `problem` of an increment as a file of FCLIB, with h5py.

        FCLIB's local problem is the one that `problem` describes, in the same units. The groups are
        `fclib_local` (`W` in compressed columns, `vectors/q`, `vectors/mu`, `spacedim`, `info`) and
        `solution` (`u`, `r`).
        """
        require_h5py()
        write_fclib(path, self.problem(increment), f"job {self.key}")

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or "_all" not in self.__dict__:
            raise AttributeError(name)
        # A figure comes before the field of its name: `wear_depth` is both.
        if name in self._all.units:
            return self._all[name]
        if name in UNITS and name in self.arrays():
            return self.arrays()[name]
        raise AttributeError(f"there is no figure and no field `{name}`")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._all.units, *UNITS]

    def _rows(self) -> list[tuple[str, Any, str]]:
        names = ("load", "at_approach", "peak_pressure", "contact_area", "stick_fraction")
        names += ("solutions", "mu_low", "mu_high", "residual", "estimate_load", "reason")
        known = self._all
        return [(name, known[name], known.units[name]) for name in names if known.get(name) is not None]

    def __repr__(self) -> str:
        said = [f"<tribosweep.Result {self.status}"]
        said += [f"{name} = {shown(value)} {unit}".rstrip() for name, value, unit in self._rows()]
        return ", ".join(said) + ">"

    def _repr_html_(self) -> str:
        return table(f"{self.status}, job {self.key[:12]}", self._rows())


def solve(
    scene: Optional[Scene] = None, numerics: Optional[Mapping[str, Any]] = None, **tables: Any
) -> Result:
    """Solves one scene in this process and returns its `Result`; nothing is stored.

    `scene` and `numerics` are the tables of a study file as dictionaries; numbers are SI, or texts
    with a unit such as "0.5 mm". The tables of the scene may be given by name instead: `punch`,
    `foundation`, `friction`, `wear`, `loading`, `domain`; so may `interior`, the stresses that are
    wanted below the surface, which is a table beside the scene. A whole study (a dictionary with "scene", or the
    path of a file) must have one point. A height map may be an array of shape (y, x) in place of
    the name of its file: `punch={"shape": "height-map", "file": heights, "unit": "um", ...}`.

    An interrupt (Ctrl-C) gives the solve up and raises KeyboardInterrupt.

    Raises `StudyError` with the place of what makes no sense.

    >>> import tribosweep
    >>> scene = {
    ...     "foundation": {"base": {"shear_modulus": "80 GPa", "poisson": 0.3}},
    ...     "punch": {"shape": "flat-disk", "radius": "1 mm"},
    ...     "friction": {"mu": 0.3},
    ...     "loading": {"steps": [{"approach": "1 um"}]},
    ... }
    >>> result = tribosweep.solve(scene, {"mesh": 16})
    >>> result.status
    'certified'
    >>> result.certificate.residual < 1e-8
    True
    """
    text, path, files = source(scene, numerics, tables)
    return Result(_native.solve(text, path, files), (text, path, files))


def source(
    scene: Optional[Scene], numerics: Optional[Mapping[str, Any]], tables: Mapping[str, Any]
) -> Source:
    """Returns the text of a study or None, the path that messages name, and the files in it."""
    if isinstance(scene, (str, os.PathLike)):
        if numerics is not None or tables:
            raise TypeError("a file has its numerics and tables in it; give it alone")
        return None, os.fspath(scene), {}
    if scene is not None and not isinstance(scene, Mapping):
        raise TypeError(f"a scene is a dictionary or the path of a file, not {type(scene).__name__}")
    if scene is not None and "scene" in scene:
        study = {**scene, **tables}
    else:
        beside = {name: tables[name] for name in BESIDE_SCENE if name in tables}
        of_scene = {name: table for name, table in tables.items() if name not in beside}
        study = {"scene": {**(scene or {}), **of_scene}, **beside}
    study.setdefault("name", "solve")
    if numerics is not None:
        study["numerics"] = {**study.get("numerics", {}), **numerics}
    text, files = study_text(study)
    return text, "<dict>", files
