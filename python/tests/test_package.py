import doctest
import io
import pathlib
import subprocess
import sys
import sysconfig
import tomllib

import numpy as np
import pytest

import tribosweep
from tribosweep import _result, _store, _study, _text

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("module", [_result, _study, _store])
def test_the_examples_of_the_documentation_run(module, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("TRIBOSWEEP_STORE", raising=False)
    if module is _store:
        pytest.importorskip("pyarrow")
        pytest.importorskip("xarray")
        # Its examples are of the store of this one.
        names = {"tribosweep": tribosweep}
        for example in doctest.DocTestParser().get_examples(tribosweep.Study.__doc__):
            exec(compile(example.source, "Study", "single"), names)
        names["study"].run()
    ran = doctest.testmod(module)
    assert ran.failed == 0 and ran.attempted > 0


@pytest.mark.parametrize(
    "told",
    [
        tribosweep.open, tribosweep.Store.fields, tribosweep.StoredStudy.query,
        tribosweep.StoredStudy.arrow, tribosweep.Study, tribosweep.Result, tribosweep.solve,
    ],
)  # fmt: skip
def test_what_people_use_has_an_example(told):
    assert doctest.DocTestParser().get_examples(told.__doc__)


def test_the_example_of_the_book_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("TRIBOSWEEP_STORE", raising=False)
    text = (ROOT / "docs/book/src/python.md").read_text()
    example = text.split("```python\n")[1].split("```")[0]
    (tmp_path / "sweeps").symlink_to(ROOT / "sweeps")
    names = {}
    exec(compile(example, "python.md", "exec"), names)
    frame = names["frame"]
    assert len(frame) > 0 and (frame.mu > 0.3).all()
    assert frame.attrs["units"]["stick_area"] == "m²"


def test_stubs_agree_with_the_module():
    pytest.importorskip("mypy")
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "tribosweep._native", "--concise"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert done.returncode == 0, done.stdout


def test_the_package_keeps_to_the_python_that_it_requires():
    pytest.importorskip("vermin")
    project = tomllib.loads((ROOT / "python" / "pyproject.toml").read_text())["project"]
    floor = project["requires-python"].removeprefix(">=")
    manifest = tomllib.loads((ROOT / "python" / "Cargo.toml").read_text())
    assert f"abi3-py{floor.replace('.', '')}" in manifest["dependencies"]["pyo3"]["features"]
    # Names and syntax that came later are violations.
    done = subprocess.run(
        [pathlib.Path(sysconfig.get_path("scripts"), "vermin"), f"-t={floor}-", "--no-tips",
         "--violations", *(ROOT / "python" / "tribosweep").glob("*.py")],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout


def test_the_command_comes_with_the_package():
    assert tribosweep.program().startswith(sysconfig.get_path("scripts"))
    said = subprocess.run([tribosweep.program(), "--version"], stdout=subprocess.PIPE, text=True)
    assert said.stdout.startswith("tribosweep ")


def test_a_dictionary_becomes_the_text_of_a_study():
    given = {
        "name": 'a "quoted"\n\x7fname',
        "scene": {"friction": {"mu": 0.1}, "list": [{"a": 1e-9}, {"b": True}], "n": float("inf")},
        "sweep": {"foundation.layers[0].thickness": [1, 2.5], "friction.mu": range(2)},
    }
    text, files = _text.study_text(given)
    read = tomllib.loads(text)
    assert read["name"] == given["name"] and read["scene"] == given["scene"] and files == {}
    assert read["sweep"]["foundation.layers[0].thickness"] == [1, 2.5]
    assert read["sweep"]["friction"]["mu"] == [0, 1]


def test_arrays_are_files_named_by_what_they_hold_and_only_where_a_file_is_named():
    heights = np.arange(6.0).reshape(2, 3)

    def text(**punch):
        return _text.study_text({
            "scene": {"punch": {"shape": "height-map", **punch}},
            "numerics": {"mesh": np.array([[8, 12]])},
            "sweep": {"punch.file": [heights, heights + 1, heights]},
        })

    written, files = text(file="array-1.npy")
    read = tomllib.loads(written)
    assert read["numerics"]["mesh"] == [[8, 12]]
    assert read["scene"]["punch"]["file"] == "array-1.npy" and "array-1.npy" not in files
    names = read["sweep"]["punch"]["file"]
    assert names[0] == names[2] != names[1] and set(names) == set(files)
    assert np.array_equal(np.load(io.BytesIO(files[names[1]])), heights + 1)
    assert tomllib.loads(text(file=heights)[0])["scene"]["punch"]["file"] == names[0]


@pytest.mark.parametrize(
    "study, place",
    [({1: 2}, "the study"), ({"scene": {2: 3}}, "scene"), ({"scene": {"a": {3: 4}}}, "scene.a")],
)
def test_a_key_that_is_no_text_is_named_with_its_place(study, place):
    with pytest.raises(TypeError, match=f"^{place}: a key must be a text"):
        _text.study_text(study)


def test_the_notebook_runs_and_has_the_numbers_of_query(tmp_path, monkeypatch):
    nbformat = pytest.importorskip("nbformat")
    client = pytest.importorskip("nbclient")
    pytest.importorskip("matplotlib")
    monkeypatch.setenv("TRIBOSWEEP_STORE", str(tmp_path / "store"))
    notebook = nbformat.read(ROOT / "docs" / "coating.ipynb", as_version=4)
    client.NotebookClient(notebook, timeout=100, kernel_name="python3").execute(cwd=str(tmp_path))
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in outputs), "a figure is drawn"
    frame = tribosweep.open(tmp_path / "store")["coated-sphere"].query(
        select="layer0_shear_modulus,stick_fraction", sort="layer0_shear_modulus"
    )
    said = [o["text"] for o in outputs if o.get("name") == "stdout"][-1]
    assert said.split() == [repr(float(value)) for value in frame.stick_fraction]
