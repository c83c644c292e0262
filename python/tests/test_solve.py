import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import tribosweep
from tribosweep import _native


def test_a_scene_is_solved_as_the_command_solves_it(scene, tmp_path):
    result = tribosweep.solve(scene, {"mesh": 24})
    study = tribosweep.Study({"name": "same", "scene": scene, "numerics": {"mesh": 24}})
    file = tmp_path / "same.toml"
    file.write_text(study.text)
    said = subprocess.run(
        [tribosweep.program(), "solve", file, "--json"], stdout=subprocess.PIPE, check=True
    )
    told = json.loads(said.stdout)
    for provenance in ("seconds", "finished"):
        told["result"].pop(provenance, None)
        result.json["result"].pop(provenance, None)
    # The command line and the file differ; the program, the machine and the scene do not.
    origins = [solved.pop("provenance") for solved in (told, result.json)]
    assert origins[0]["program"] == origins[1]["program"]
    assert origins[0]["machine"] == origins[1]["machine"]
    assert told == result.json
    assert tribosweep.solve(file).peak_pressure == result.peak_pressure
    output = tmp_path / "pressure.npy"
    subprocess.run(
        [tribosweep.program(), "solve", file, "--field", "pressure", "--output", output],
        stdout=subprocess.DEVNULL,
        check=True,
    )
    written = np.load(output)
    assert np.array_equal(written[~np.isnan(written)], result.pressure[result.state > 0])


def test_a_result_has_every_plane_and_point_below_the_surface(scene):
    asked = {"depths": [2e-4, 1e-4], "points": [[0, 0, 1e-4], [0, 0, 0]]}
    study = {"name": "below", "scene": scene, "interior": asked, "numerics": {"mesh": 16}}
    result = tribosweep.solve(study)
    assert [plane["depth"] for plane in result.planes] == [1e-4, 2e-4]
    assert result.planes[0]["von_mises"] == result.plane_von_mises
    assert [point["z"] for point in result.points] == [1e-4, 0]
    assert result.points[0]["xx"] == result.stress_xx
    silent = tribosweep.solve(scene, {"mesh": 16})
    assert silent.planes == [] and silent.points == []


def test_a_result_has_figures_and_fields_with_units(scene):
    result = tribosweep.solve(scene, {"mesh": 24})
    assert result.certified and result.status == "certified"
    assert result.provenance["program"]["version"]
    assert result.provenance["study"]["file"] is None
    assert result.certificate.residual < 1e-8
    assert 0 < result.estimates.estimate_load < 1
    assert result.observables["load"] == result.load
    assert result.units["load"] == "N" and result.units["pressure"] == "Pa"
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    assert result.pressure.sum() * area == pytest.approx(result.load, rel=1e-12)
    assert result.traction_x.sum() * area == pytest.approx(result.force_x, rel=1e-9)
    assert (result.state == 2).sum() == result.stick_elements
    assert "certified" in repr(result) and "<table>" in result._repr_html_()
    with pytest.raises(AttributeError, match="no figure and no field `presure`"):
        result.presure


def test_wear_is_a_figure_and_a_field(scene):
    steps = [{"approach": "20 um"}, {"shift_x": "60 um", "increments": 2}]
    tables = {**scene, "loading": {"steps": steps}}
    numerics = {"mesh": [16, 12]}
    plain = tribosweep.solve(numerics=numerics, **tables)
    assert plain.wear_depth is None and "wear_depth" not in plain.arrays()
    assert not hasattr(plain, "no_such_name") and hasattr(plain, "wear_depth")
    worn = tribosweep.solve(numerics=numerics, **tables, wear={"coefficient": "1e-8 1/MPa"})
    depth = worn.arrays()["wear_depth"]
    assert depth.shape == (12, 16) and worn.wear_depth == depth.max() > 0
    assert worn.units["wear_depth"] == "m"
    assert worn.arrays(steps=True)["wear_depth"].shape == (2 + 1, 12, 16)
    # The depth is k/μ times the work, and the work adds up to the energy lost.
    area = (worn.x[1] - worn.x[0]) * (worn.y[1] - worn.y[0])
    work = worn.arrays(steps=True)["friction_work"].sum(axis=(1, 2)) * area
    assert worn.wear_volume == pytest.approx(1e-14 / 0.3 * work.sum(), rel=1e-6)
    assert np.array_equal(worn.friction_work, worn.arrays(steps=True)["friction_work"][-1])
    pytest.importorskip("xarray")
    fields = worn.fields()
    assert float(fields.wear_depth.max()) == worn.wear_depth
    assert fields.friction_work.attrs["units"] == "J/m²"
    assert "wear_depth" not in plain.fields()


def test_tables_by_name_stand_where_they_belong(scene):
    asked = {"points": [[0, 0, "0.5 mm"]], "maximum": True}
    result = tribosweep.solve(**scene, numerics={"mesh": 12}, interior=asked)
    assert result.certified and result.job["interior"]["points"] == [[0, 0, 5e-4]]
    assert "interior" not in result.job["scene"]
    study = {"scene": scene, "numerics": {"mesh": 12}, "interior": asked}
    assert tribosweep.solve(study).key == result.key
    assert tribosweep.solve({"scene": scene}, {"mesh": 12}, interior=asked).key == result.key


def test_fields_have_coordinates(scene):
    pytest.importorskip("xarray")
    result = tribosweep.solve(scene, {"mesh": [24, 16]})
    fields = result.fields()
    assert dict(fields.sizes) == {"y": 16, "x": 24}
    assert fields.pressure.attrs["units"] == "Pa"
    assert float(fields.pressure.max()) == result.peak_pressure


def test_what_makes_no_sense_is_shown_at_its_place(scene):
    scene["friction"] = {"mu": -0.3}
    with pytest.raises(tribosweep.StudyError) as caught:
        tribosweep.solve(scene, {"mesh": 16})
    assert isinstance(caught.value, ValueError)
    assert "mu = -0.3" in str(caught.value) and "<dict>" in str(caught.value)
    [(line, column, message)] = caught.value.places
    assert caught.value.args[0].splitlines()[1].strip().startswith(f"--> <dict>:{line}:{column}")
    with pytest.raises(tribosweep.StudyError, match="did you mean"):
        tribosweep.solve({**scene, "friction": {"muu": 0.3}}, {"mesh": 16})
    with pytest.raises(TypeError, match="punch"):
        tribosweep.solve({**scene, "punch": object()})
    with pytest.raises(tribosweep.Error, match="cannot read the study file"):
        tribosweep.solve("nowhere.toml")


def test_an_array_is_a_height_map(scene):
    x = np.linspace(-1e-3, 1e-3, 64)
    heights = -(x[None, :] ** 2 + 2 * x[:, None] ** 2) / (2 * 50e-3)
    scene["punch"] = {
        "shape": "height-map", "file": heights, "unit": "m", "width_x": 2e-3, "width_y": 2e-3,
    }  # fmt: skip
    scene["loading"] = {"steps": [{"approach": "2 um"}]}
    result = tribosweep.solve(scene, {"mesh": 32})
    # The curvature along y is twice that along x, so the contact is longer along x.
    contact = result.pressure > 0
    assert contact.any(axis=0).sum() > contact.any(axis=1).sum()


def test_python_goes_on_while_a_scene_is_solved(scene, monkeypatch):
    began, ran = threading.Event(), []
    native, within = _native.solve, []

    def solve(*arguments):
        began.set()
        before = len(ran)
        solved = native(*arguments)
        within.append(len(ran) - before)
        return solved

    def run():
        began.wait()
        ran.append(True)

    monkeypatch.setattr(_native, "solve", solve)
    thread = threading.Thread(target=run)
    thread.start()
    # Nothing but the call itself gives the lock to the other thread.
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000)
    try:
        tribosweep.solve(scene, {"mesh": 96})
    finally:
        sys.setswitchinterval(interval)
        thread.join()
    assert within == [1]


def test_a_figure_that_is_0_is_shown(scene):
    scene["friction"] = {"mu": 0.3}
    scene["loading"] = {"steps": [{"approach": "20 um"}, {"shift_x": "40 um"}]}
    result = tribosweep.solve(scene, {"mesh": 16})
    assert result.stick_fraction == 0 and "stick_fraction = 0" in repr(result)


def test_an_interrupt_gives_a_solve_up(scene):
    # A path that takes far longer than the test.
    scene["loading"] = {"steps": [{"approach": "20 um", "shift_x": "4 um", "increments": 1000}]}
    sent = []

    def interrupt():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.3, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        tribosweep.solve(scene, {"mesh": 128})
    assert sent, "the interrupt came from here"
    # No thread goes on with the work that nobody wants.
    before = time.process_time()
    time.sleep(0.3)
    assert time.process_time() - before < 0.2
    scene["loading"] = {"steps": [{"approach": "20 um"}]}
    assert tribosweep.solve(scene, {"mesh": 16}).certified


def load_of(scene):
    return tribosweep.solve(scene, {"mesh": 16}).load


def test_a_forked_child_solves_with_threads_of_its_own(scene):
    here = load_of(scene)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(load_of, [scene, scene]).get(timeout=60) == [here, here]
