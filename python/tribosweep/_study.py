"""Studies, run by the command with its coordinator and workers."""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Optional, Union

from . import _native
from ._errors import RunError
from ._html import table
from ._result import source
from ._store import StoredStudy, open, usual_store


def program() -> str:
    """Returns the path of the command `tribosweep` that came with this package.

    TRIBOSWEEP_PROGRAM names another one.
    """
    named = os.environ.get("TRIBOSWEEP_PROGRAM")
    if named:
        return named
    here = pathlib.Path(__file__).resolve().parent
    places = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", f"{os.name}_user")]
    # What `pip install --target` makes.
    places += [os.path.dirname(sys.executable), str(here.parent / "bin")]
    for place in places:
        path = os.path.join(place, "tribosweep")
        if os.access(path, os.X_OK) and os.path.isfile(path):
            return path
    found = shutil.which("tribosweep")
    if found:
        return found
    raise RunError(
        f"the command tribosweep is not in {', '.join(places)}; install the package again, or "
        "name it in TRIBOSWEEP_PROGRAM"
    )


class Said(dict):
    """What the command says as JSON, also as attributes."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None


class Plan(Said):
    """What a study would run: `points`, `jobs`, `cached`, `to_run`, `predicted_seconds` [s] …"""

    def __repr__(self) -> str:
        return (
            f"<tribosweep.Plan {self.study}: {self.points} points, {self.jobs} jobs, "
            f"{self.cached} in the store, {self.to_run} to run in about "
            f"{self.predicted_seconds:.2g} s on {self.workers} workers>"
        )

    def _repr_html_(self) -> str:
        names = ("points", "jobs", "cached", "to_run", "predicted_seconds", "workers")
        return table(self.study, ((name, self[name]) for name in names))


class Run(Said):
    """What came of a run: `progress` in points, `run` in jobs, `failures`, `answers`, `figures`."""

    #: The study in its store.
    results: StoredStudy

    def __repr__(self) -> str:
        progress = self.progress
        return (
            f"<tribosweep.Run {self.study}: {progress['points']} points, {progress['done']} "
            f"certified, {progress['failed']} failed, {progress['left']} left>"
        )

    def _repr_html_(self) -> str:
        return table(f"run of {self.study}", self.progress.items())


class Study:
    """A study: the path of its file, or the same as a dictionary.

    It is checked at once, and `StudyError` shows the place of what makes no sense.

    >>> import tribosweep
    >>> study = tribosweep.Study({
    ...     "name": "stick-zone-of-a-coating",
    ...     "scene": {
    ...         "foundation": {
    ...             "layers": [{"shear_modulus": "8 GPa", "poisson": 0.3, "thickness": "0.5 mm"}],
    ...             "base": {"shear_modulus": "80 GPa", "poisson": 0.3},
    ...         },
    ...         "punch": {"shape": "flat-disk", "radius": "1 mm"},
    ...         "friction": {"mu": 0.3},
    ...         "loading": {"steps": [{"approach": "1 um"}]},
    ...     },
    ...     "numerics": {"mesh": 16},
    ...     "sweep": {"friction.mu": [0.2, 0.4]},
    ... })
    >>> study
    <tribosweep.Study stick-zone-of-a-coating: 2 points over mu>
    """

    def __init__(self, study: Union[str, os.PathLike[str], Mapping[str, Any]]) -> None:
        if isinstance(study, Mapping) and "scene" not in study:
            study = {**study, "scene": {}}
        self._text, self._path, files = source(study, None, {})
        checked = _native.check(self._text, self._path, files)
        self._files = checked.get("files", {})
        self.name: str = checked["name"]
        self.question: str = checked["question"]
        self.kind: str = checked["kind"]
        #: The number of points that the axes make.
        self.points: int = checked["points"]
        #: The names of the axes' columns.
        self.axes: list[str] = checked["axes"]
        #: The text of the study file, whether there is one or not.
        self.text: str = checked["text"]

    def plan(self, store: Union[str, os.PathLike[str], None] = None) -> Plan:
        """Returns what the study would run; runs nothing."""
        with self._file() as file:
            command = [program(), "plan", file, "--json", f"--store={usual_store(store)}"]
            done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        if done.returncode != 0:
            raise RunError(_error(done.stderr.decode(errors="replace")))
        return Plan(json.loads(done.stdout))

    def run(
        self,
        store: Union[str, os.PathLike[str], None] = None,
        *,
        workers: Optional[int] = None,
        memory: Optional[str] = None,
        until: Optional[str] = None,
        retry_failed: bool = False,
        progress: Union[bool, Callable[[dict[str, Any]], None]] = False,
        patience: float = 0.5,
    ) -> Run:
        """Runs what the store has no results of, on worker processes, and returns what came of it.

        `progress` is called with every event as a dictionary (those of `run --json`); True prints
        a line on standard error that counts, at most ten times a second. `memory` ("8GiB") and
        `until` ("55m") are those of the command. An interrupt (Ctrl-C, "interrupt the kernel") ends
        the run and raises KeyboardInterrupt: no job is begun any more, and those in flight have
        `patience` seconds to be finished and kept. The others are done anew by the same call, which
        goes on where it was. A second interrupt ends the patience.

        Raises `RunError` if the run could not go on. Jobs that fail are no error: `failures`.
        """
        place = usual_store(store)
        options: list[str] = []
        for name, value in (("--workers", workers), ("--memory", memory), ("--until", until)):
            options += [] if value is None else [f"{name}={value}"]
        options += ["--retry-failed"] if retry_failed else []
        with self._file() as file:
            command = [program(), "run", file, "--json", f"--store={place}", *options]
            summary = _follow(command, _listener(progress), patience)
        run = Run(summary)
        run.__dict__["results"] = open(place)[self.name]
        return run

    @contextmanager
    def _file(self) -> Iterator[str]:
        """Gives the path of the study's file, which is a temporary one for a dictionary."""
        if self._text is None:
            # No path is an option, whatever it begins with.
            yield os.path.join(".", self._path) if self._path.startswith("-") else self._path
            return
        with tempfile.TemporaryDirectory(prefix="tribosweep-study-") as top:
            # The files have the same names from there, also those that lead upwards.
            above = max((name.split("/").count("..") for name in self._files), default=0)
            beside = pathlib.Path(top, *("x" for _ in range(above)))
            beside.mkdir(parents=True, exist_ok=True)
            for name, content in self._files.items():
                if not os.path.isabs(name):
                    path = pathlib.Path(os.path.normpath(beside / name))
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.write_bytes(content)
            file = beside / f"{self.name}.toml"
            file.write_text(self._text, encoding="utf-8")
            yield str(file)

    def __repr__(self) -> str:
        axes = ", ".join(self.axes) or "no axes"
        return f"<tribosweep.Study {self.name}: {self.points} points over {axes}>"

    def _repr_html_(self) -> str:
        rows = [("question", self.question), ("kind", self.kind), ("points", self.points)]
        return table(self.name, [*rows, ("axes", ", ".join(self.axes))])


def _follow(
    command: list[str], listen: Callable[[dict[str, Any]], None], patience: float
) -> dict[str, Any]:
    """Follows a run to its end and returns its summary."""
    # A session of its own, so that an interrupt reaches it once, and from here.
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    assert process.stdout is not None and process.stderr is not None
    said: list[str] = []
    errors = process.stderr
    reader = threading.Thread(
        target=lambda: said.extend(line.decode(errors="replace") for line in errors), daemon=True
    )
    reader.start()
    summary: dict[str, Any] = {}
    stopped: Optional[BaseException] = None
    # A second signal ends a run without waiting for its jobs.
    ender = threading.Timer(patience, process.send_signal, (signal.SIGINT,))
    ender.daemon = True
    while True:
        try:
            line = process.stdout.readline()
            if not line:
                break
            event = json.loads(line)
            if event.get("event") == "summary":
                summary = event
            elif stopped is None:
                listen(event)
        except BaseException as error:
            # Interrupted, or the listener has failed: what is in flight is finished and kept.
            if stopped is None:
                ender.start()
            stopped = stopped or error
            process.send_signal(signal.SIGINT)
    code = process.wait()
    ender.cancel()
    reader.join()
    process.stdout.close()
    errors.close()
    if stopped is not None:
        raise stopped
    if code == 130:
        raise KeyboardInterrupt
    if code == 1 or not summary:
        raise RunError(_error("".join(said)) or f"the run ended with code {code}")
    for line in said:
        warnings.warn(line.rstrip(), stacklevel=3)
    return summary


def _listener(progress: Union[bool, Callable[[dict[str, Any]], None]]) -> Callable[[Any], None]:
    if callable(progress):
        return progress
    return Counter(sys.stderr) if progress else lambda event: None


class Counter:
    """Counts the jobs on one line of a terminal or a notebook.

    A line is written at most every `SECONDS`, and one at the end.
    """

    SECONDS = 0.1

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self._next = 0.0

    def __call__(self, event: Mapping[str, Any]) -> None:
        is_last = event.get("event") == "finished"
        now = time.monotonic()
        if "counts" not in event or not (is_last or now >= self._next):
            return
        self._next = now + self.SECONDS
        counts, left = event["counts"], event.get("seconds_left")
        about = f", about {left:.0f} s left" if left else ""
        waiting = counts.get("waiting", 0) + counts.get("running", 0)
        line = f"\r{counts.get('done', 0)} done, {waiting} to go{about}  "
        print(line, end="\n" if is_last else "", file=self._stream, flush=True)


def _error(said: str) -> str:
    """Returns the words of an error as an exception has them."""
    lines = said.strip()
    return lines[len("error: ") :] if lines.startswith("error: ") else lines
