import contextlib
import csv
import gc
import io
import json
import multiprocessing
import os
import pathlib
import signal
import subprocess
import threading
import time

import numpy as np
import pytest

import tribosweep
from tribosweep import _study


def sweep(scene, values=(0.1, 0.3, 0.5), mesh=12):
    return {
        "name": "friction",
        "question": "What does friction do?",
        "scene": scene,
        "numerics": {"mesh": mesh},
        "sweep": {"friction.mu": list(values)},
    }


def command(*words):
    done = subprocess.run([tribosweep.program(), *map(str, words)], stdout=subprocess.PIPE, check=True)
    return done.stdout.decode()


def test_a_study_is_planned_run_and_queried(scene, store):
    study = tribosweep.Study(sweep(scene))
    assert (study.name, study.points, study.axes) == ("friction", 3, ["mu"])
    assert study.plan(store).to_run == 3
    events = []
    run = study.run(store, workers=2, progress=events.append)
    assert run.progress == {"points": 3, "done": 3, "failed": 0, "left": 0}
    assert {"finished", "committed"} <= {event["event"] for event in events}
    assert study.plan(store).to_run == 0
    assert study.run(store).run["cached"] == 3

    frame = run.results.query("mu > 0.2", select="mu,load,contact_elements,key", sort="-mu")
    said = command(
        "query", "friction", "--store", store, "--where", "mu > 0.2",
        "--select", "mu,load,contact_elements,key", "--sort=-mu", "--format", "csv",
    )  # fmt: skip
    rows = list(csv.DictReader(io.StringIO(said)))
    assert [str(mu) for mu in frame.mu] == [row["mu"] for row in rows] == ["0.5", "0.3"]
    assert [float(row["load"]) for row in rows] == list(frame.load)
    assert frame.attrs["units"]["load"] == "N" and frame.contact_elements.dtype == np.int64
    assert [row["key"] for row in rows] == list(frame.key)

    stored = tribosweep.open(store)
    assert list(stored) == ["friction"] and stored["friction"].question.startswith("What")
    assert "friction" in repr(stored) and "<table>" in stored._repr_html_()
    arrays = stored.arrays(frame.key[0][:12])
    assert arrays["pressure"].shape == (12, 12)
    assert stored.show(frame.key[0])["result"]["load"] == frame.load[0]
    assert "meaning" in stored["friction"].columns().columns
    with pytest.raises(tribosweep.QueryError, match="no column `lod`; did you mean load"):
        stored["friction"].query(select="lod")
    with pytest.raises(tribosweep.QueryError):
        stored["friction"].query("mu >")
    with pytest.raises(KeyError, match="it has friction"):
        stored["fiction"]


def test_stored_fields_are_a_dataset(scene, store):
    pytest.importorskip("xarray")
    run = tribosweep.Study(sweep(scene)).run(store)
    frame = run.results.query(select="key,peak_pressure")
    fields = run.results.fields(frame.key[0])
    assert float(fields.pressure.max()) == frame.peak_pressure[0]
    assert fields.attrs["key"] == frame.key[0] and fields.attrs["certified"] == 1


def test_parquet_and_arrow_agree_with_pandas_and_duckdb(scene, store, tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    duckdb = pytest.importorskip("duckdb")
    import pandas

    results = tribosweep.Study(sweep(scene)).run(store).results
    file = tmp_path / "results.parquet"
    command("query", "friction", "--store", store, "--format", "parquet", "--output", file)
    assert not list(tmp_path.glob("*.part"))
    whole = parquet.read_table(file)
    names = whole.column_names
    assert names == list(results.columns().index)
    frame = results.query(select=names)
    read = pandas.read_parquet(file)
    assert read.attrs["units"]["peak_pressure"] == "Pa" == frame.attrs["units"]["peak_pressure"]
    assert "largest" in read.attrs["meanings"]["peak_pressure"]
    for name in names:
        ours, theirs = frame[name], read[name]
        assert (ours.isna() == theirs.isna()).all(), name
        assert list(ours.dropna()) == list(theirs.dropna()), name
    said = json.loads(whole.schema.metadata[b"tribosweep.columns"])
    assert [column["name"] for column in said] == names
    arrow = results.arrow(select=names)
    assert arrow.schema.field("load").metadata[b"unit"] == b"N"
    # What is missing is null in both, and no number.
    for name in names:
        assert arrow.column(name).to_pylist() == whole.column(name).to_pylist(), name
    assert any(whole.column(name).null_count for name in names if arrow.schema.field(name).type == pyarrow.float64())
    assert whole.schema.field("contact_elements").type == pyarrow.int64()
    found = duckdb.sql(f"select mu, load from '{file}' where mu > 0.2 order by mu").fetchall()
    assert [load for _, load in found] == list(results.query("mu > 0.2", sort="mu").load)


def test_a_mesh_that_is_a_pair_widens_its_column(scene, store, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    study = sweep(scene)
    study["sweep"] = {"mesh": [8, [8, 12]]}
    del study["numerics"]
    tribosweep.Study(study).run(store)
    file = tmp_path / "results.parquet"
    command("query", "friction", "--store", store, "--format", "parquet", "--output", file)
    assert parquet.read_table(file).column("mesh").to_pylist() == ["8", "8x12"]


def test_a_dictionary_with_arrays_and_files_runs(scene, store, tmp_path, monkeypatch):
    beside = tmp_path / "here" / "below"
    beside.mkdir(parents=True)
    monkeypatch.chdir(beside)
    x = np.linspace(-1, 1, 24)
    heights = -(x[None, :] ** 2 + x[:, None] ** 2)
    np.save(beside.parent / "heights.npy", heights)
    scene["loading"] = {"steps": [{"approach": "0.1 um"}]}
    loads = []
    for file in (heights, "../heights.npy"):
        scene["punch"] = {
            "shape": "height-map", "file": file, "unit": "um", "width_x": 1e-3, "width_y": 1e-3,
        }  # fmt: skip
        loads.append(tribosweep.Study(sweep(scene)).run(store).results.query().load)
    assert (loads[0] == loads[1]).all() and loads[0][0] > 0


def test_what_cannot_be_run_or_read_is_said_in_words(scene, store, tmp_path):
    with pytest.raises(tribosweep.StoreError, match="no store"):
        tribosweep.open(store)
    (tmp_path / "file").write_text("")
    with pytest.raises(tribosweep.RunError):
        tribosweep.Study(sweep(scene)).run(tmp_path / "file")
    with pytest.raises(tribosweep.StudyError, match="friction.toml:"):
        (tmp_path / "friction.toml").write_text("name = 3\n")
        tribosweep.Study(tmp_path / "friction.toml")


def test_a_path_is_no_option_whatever_it_begins_with(scene, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("TRIBOSWEEP_STORE", raising=False)
    (tmp_path / "-friction.toml").write_text(tribosweep.Study(sweep(scene)).text)
    study = tribosweep.Study("-friction.toml")
    assert study.plan("-store").to_run == 3
    assert study.run("-store").progress["done"] == 3
    assert len(tribosweep.open("-store")["friction"].query()) == 3


def test_a_store_that_was_opened_shows_what_is_run_afterwards(scene, store, tmp_path, monkeypatch):
    tribosweep.Study(sweep(scene, [0.1])).run(store)
    opened = tribosweep.open(os.path.relpath(store))
    assert len(opened["friction"].query("load > 0")) == 1
    tribosweep.Study(sweep(scene, [0.1, 0.2])).run(store)
    tribosweep.Study({**sweep(scene, [0.3]), "name": "other"}).run(store)
    # The store is read where it was opened.
    monkeypatch.chdir(tmp_path)
    results = opened["friction"]
    assert len(results.query("load > 0")) == 2 and sorted(opened) == ["friction", "other"]
    tribosweep.Study(sweep(scene, [0.1, 0.2, 0.4])).run(store)
    assert len(results.query("load > 0")) == 3
    assert results.fields(results.query("mu == 0.4", select="key").key[0])
    exported = tmp_path / "results"
    exported.mkdir()
    command("store", "export", exported / "one.tribosweep", "--store", store)
    opened = tribosweep.open(exported)
    assert len(opened["friction"].query("load > 0")) == 3
    tribosweep.Study(sweep(scene, [0.1, 0.2, 0.4, 0.5])).run(store)
    (exported / "one.tribosweep").unlink()
    command("store", "export", exported / "two.tribosweep", "--store", store)
    assert len(opened["friction"].query("load > 0")) == 4


OPENED = {}


def ask(times, answers):
    """Puts the same questions many times and counts answers that are wrong."""
    results = OPENED["store"]["friction"]
    wrong = 0
    for _ in range(times):
        for mu, load in answers.items():
            wrong += list(results.query(f"mu == {mu}", select="load").load) != [load]
    return wrong


def test_a_forked_child_asks_for_itself(scene, store):
    """While a run writes, both would have the same connection to it."""

    class Enough(Exception):
        pass

    found = []

    def listen(event):
        if event["event"] != "committed" or event.get("counts", {}).get("done", 0) < 4:
            return
        opened = OPENED["store"] = tribosweep.open(store)
        frame = opened["friction"].query("load > 0", select="mu,load")
        answers = dict(zip(frame.mu[:4], frame.load[:4]))
        with multiprocessing.get_context("fork").Pool(2) as pool:
            asked = [pool.apply_async(ask, (8, answers)) for _ in range(2)]
            found.append(ask(8, answers))
            found.extend(one.get(timeout=60) for one in asked)
        found.extend(opened.notes)
        raise Enough

    study = tribosweep.Study(sweep(scene, np.linspace(0.05, 0.9, 400), mesh=48))
    with pytest.raises(Enough):
        study.run(store, workers=2, progress=listen)
    OPENED.clear()
    assert found[:3] == [0, 0, 0] and "served by the running process" in found[3]


def leave(opened):
    # The only reference to what is shared with the parent.
    opened._native = None
    gc.collect()


def test_a_forked_child_leaves_the_copy_of_its_parent(scene, store):
    tribosweep.Study(sweep(scene)).run(store)
    opened = tribosweep.open(store)
    frame = opened["friction"].query()
    child = multiprocessing.get_context("fork").Process(target=leave, args=(opened,))
    child.start()
    child.join(60)
    assert child.exitcode == 0
    assert opened["friction"].query().equals(frame)


def test_an_interrupt_ends_a_run_softly(scene, store):
    study = tribosweep.Study(sweep(scene, np.linspace(0.05, 0.9, 400), mesh=48))
    events = []

    def listen(event):
        events.append(event)
        if event["event"] == "committed" and not any(e.get("sent") for e in events):
            events.append({"event": "sent", "sent": True})
            threading.Thread(target=os.kill, args=(os.getpid(), signal.SIGINT)).start()

    with pytest.raises(KeyboardInterrupt):
        study.run(store, workers=2, progress=listen, patience=60)
    left = study.plan(store).to_run
    assert 0 < left < 400, "some jobs were finished and kept, and others were not begun"
    end = time.monotonic() + 5
    while tribosweep.open(store).notes and time.monotonic() < end:
        time.sleep(0.05)
    assert tribosweep.open(store).notes == [], "no process writes the store any more"


def test_an_interrupt_does_not_wait_for_long_jobs(scene, store):
    # Jobs that take far longer than the test.
    scene["loading"] = {"steps": [{"approach": "20 um", "shift_x": "4 um", "increments": 1000}]}
    study = tribosweep.Study(sweep(scene, (0.2, 0.3), mesh=128))
    shared = pathlib.Path("/dev/shm")
    of_run = set()

    def listen(event):
        if event["event"] == "leased":
            # Other runs of this machine have theirs there as well, and may end at any time.
            for root in shared.glob("tribo-*"):
                with contextlib.suppress(OSError):
                    if store in (root / "bodies").readlink().parents:
                        of_run.add(root.name)
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        study.run(store, workers=2, progress=listen)
    assert study.plan(store).to_run == 2
    assert tribosweep.open(store).notes == [], "no process writes the store any more"
    assert of_run, "the run was seen in shared memory"
    left = [path.name for path in shared.iterdir() if path.name.startswith(tuple(of_run))]
    assert left == [], "nothing is left in shared memory"


def test_progress_is_a_few_lines_a_second(monkeypatch):
    moment = [0.0]
    monkeypatch.setattr(_study.time, "monotonic", lambda: moment[0])
    stream = io.StringIO()
    count = _study.Counter(stream)
    counts = {"waiting": 1, "running": 1, "done": 0}
    for number in range(10_000):
        moment[0] = number / 1000
        count({"event": "committed", "counts": {**counts, "done": number}})
    count({"event": "finished", "counts": {"waiting": 0, "running": 0, "done": 10_000}})
    lines = stream.getvalue().split("\r")[1:]
    assert 95 <= len(lines) <= 102 and lines[-1].startswith("10000 done, 0 to go")


def test_a_listener_that_fails_ends_the_run(scene, store):
    def listen(event):
        raise LookupError("no")

    with pytest.raises(LookupError):
        tribosweep.Study(sweep(scene)).run(store, progress=listen)


def test_the_store_is_read_while_a_run_writes_it(scene, store):
    seen = []

    def listen(event):
        if event["event"] == "committed" and not seen:
            opened = tribosweep.open(store)
            seen.append((opened.notes, len(opened["friction"].query("load > 0"))))

    tribosweep.Study(sweep(scene, np.linspace(0.05, 0.9, 60))).run(store, progress=listen)
    notes, rows = seen[0]
    assert rows >= 1 and (not notes or "served by the running process" in notes[0])
