import base64
import subprocess
import xml.etree.ElementTree as xml

import numpy as np
import pytest

import tribosweep

NAMES = ("pressure", "traction_x", "traction_y", "gap", "slip_x", "slip_y", "friction_work", "state")


@pytest.fixture
def pulled(scene):
    """A path of three increments."""
    scene["loading"] = {
        "steps": [{"approach": "20 um"}, {"approach": "20 um", "shift_x": "4 um", "increments": 2}]
    }
    return scene


def test_the_fields_of_all_increments_belong_to_their_figures(pulled, store):
    study = {"name": "pulled", "scene": pulled, "numerics": {"mesh": [12, 8]}}
    result = tribosweep.solve(study)
    path = result.arrays(steps=True)
    assert path["pressure"].shape == (3, 8, 12)
    for name in NAMES:
        assert np.array_equal(path[name][-1], getattr(result, name)), name
    stored = tribosweep.Study(study).run(store).results
    frame = stored.query(select="increment,load,force_x,key", steps=True)
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    for number in range(3):
        assert path["pressure"][number].sum() * area == pytest.approx(frame.load[number])
        assert path["traction_x"][number].sum() * area == pytest.approx(frame.force_x[number])
    again = tribosweep.open(store).arrays(frame.key[0], steps=True)
    assert all(np.array_equal(again[name], path[name]) for name in (*NAMES, "x", "y"))
    pytest.importorskip("xarray")
    fields = stored.fields(frame.key[0], steps=True)
    assert dict(fields.sizes) == {"increment": 3, "y": 8, "x": 12}
    assert list(fields.increment) == [1, 2, 3] and fields.pressure.attrs["units"] == "Pa"
    assert fields.attrs["key"] == frame.key[0]
    assert result.fields(steps=True).pressure.equals(fields.pressure)


def image(file):
    """Reads the cell data of a VTK image by VTK's description of the format."""
    piece = xml.parse(file).getroot().find("ImageData")
    extent = [int(n) for n in piece.get("WholeExtent").split()]
    shape = (extent[3], extent[1])
    arrays = {}
    for array in piece.iter("DataArray"):
        block = base64.b64decode(array.text.strip())
        kind = {"Float64": "<f8", "UInt8": "u1"}[array.get("type")]
        assert int.from_bytes(block[:8], "little") == len(block) - 8
        arrays[array.get("Name")] = np.frombuffer(block[8:], kind).reshape(shape)
    return arrays


def files_of(series):
    """Reads the places and files of a series."""
    root = xml.parse(series).getroot()
    assert root.get("type") == "Collection"
    listed = [(entry.get("timestep"), entry.get("file")) for entry in root.iter("DataSet")]
    return [float(time) for time, _ in listed], [series.parent / file for _, file in listed]


def command(*words, fails=False):
    done = subprocess.run(
        [tribosweep.program(), *map(str, words)], capture_output=True, text=True
    )
    assert (done.returncode != 0) == fails, done.stderr
    return done.stderr if fails else done.stdout


def test_a_series_has_a_file_for_each_increment(pulled, store, tmp_path):
    study = tribosweep.Study({"name": "pulled", "scene": pulled, "numerics": {"mesh": [12, 8]}})
    path = tribosweep.solve(pulled, {"mesh": [12, 8]}).arrays(steps=True)
    scene = tmp_path / "pulled.toml"
    scene.write_text(study.text)
    key = study.run(store).results.query(select="key").key[0]
    solved, shown = tmp_path / "solved.pvd", tmp_path / "shown.v2.pvd"
    assert command("solve", scene, "--output", solved) == f"{solved}\n"
    command("show", key, "--store", store, "--output", shown)
    for series in (solved, shown):
        times, files = files_of(series)
        assert times == [1, 2, 3]
        for number, file in enumerate(files):
            arrays = image(file)
            assert set(arrays) == {*NAMES, "traction"}
            for name in NAMES:
                assert np.array_equal(arrays[name], path[name][number]), (name, number)
    slips = tmp_path / "slip.pvd"
    command("show", key, "--store", store, "--field", "slip_x", "--output", slips)
    assert [set(image(file)) for file in files_of(slips)[1]] == [{"slip_x"}] * 3
    # All fields of the last increment need no solve.
    last = tmp_path / "last.vti"
    command("show", key, "--store", store, "--output", last)
    assert np.array_equal(image(last)["pressure"], path["pressure"][-1])
    said = command("show", key, "--store", store, "--output", tmp_path / "p.png", fails=True)
    assert "a .png holds one field; name it by --field (pressure," in said


def test_vtk_reads_a_series(pulled, tmp_path):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    study = tribosweep.Study({"name": "pulled", "scene": pulled, "numerics": {"mesh": [12, 8]}})
    scene, series = tmp_path / "pulled.toml", tmp_path / "path.pvd"
    scene.write_text(study.text)
    command("solve", scene, "--output", series)
    path = tribosweep.solve(scene).arrays(steps=True)
    times, files = files_of(series)
    assert len(files) == 3
    for number, file in enumerate(files):
        reader = vtk.vtkXMLImageDataReader()
        reader.SetFileName(str(file))
        reader.Update()
        data = reader.GetOutput()
        values = vtk_to_numpy(data.GetCellData().GetArray("pressure")).reshape(8, 12)
        assert np.array_equal(values, path["pressure"][number])
        assert data.GetSpacing()[0] == pytest.approx(path["x"][1] - path["x"][0])


def test_what_has_no_path_says_so(scene, store, tmp_path):
    study = {
        "name": "several",
        "scene": scene,
        "numerics": {"mesh": 6},
        "kind": "multiplicity",
        "search": {"starts": 1},
    }
    with pytest.raises(tribosweep.Error, match="keeps the fields of its last increment only"):
        tribosweep.solve(study).arrays(steps=True)
