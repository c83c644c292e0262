import builtins
import json
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import tribosweep

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))


def read(path):
    """Reads a local problem by the layout that FCLIB publishes, and by nothing else."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(path) as file:
        local = file["fclib_local"]
        matrix = {name: local["W"][name][()] for name in ("nzmax", "m", "n", "nz", "p", "i", "x")}
        assert local["spacedim"][()] == [3] and matrix["nz"] == [-1]
        n = int(matrix["n"][0])
        assert int(matrix["nzmax"][0]) == len(matrix["x"]) == matrix["p"][-1]
        W = np.zeros((int(matrix["m"][0]), n))
        for column in range(n):
            place = slice(matrix["p"][column], matrix["p"][column + 1])
            W[matrix["i"][place], column] = matrix["x"][place]
        vectors, solution = local["vectors"], file["solution"]
        return W, vectors["q"][()], vectors["mu"][()], solution["r"][()], solution["u"][()]


def gauss_seidel(W, q, mu, r, tolerance=1e-13, most=100_000):
    """Solves a local problem by nonsmooth Gauss–Seidel (Jourdan, Alart, Jean 1998).

    Each contact takes a step of the projection with De Saxcé's change of variable.
    """
    r = r.copy()
    contacts = len(mu)
    rho = [1 / np.linalg.norm(W[3 * e : 3 * e + 3, 3 * e : 3 * e + 3], 2) for e in range(contacts)]
    for _ in range(most):
        change = 0.0
        for e in range(contacts):
            rows = slice(3 * e, 3 * e + 3)
            u = W[rows] @ r + q[rows]
            u[0] += mu[e] * np.hypot(u[1], u[2])
            new = onto_cone(r[rows] - rho[e] * u, mu[e])
            change = max(change, np.abs(new - r[rows]).max())
            r[rows] = new
        if change <= tolerance * np.abs(r).max():
            return r
    raise AssertionError("the iteration does not converge")


def onto_cone(x, mu):
    tangential = np.hypot(x[1], x[2])
    if tangential <= mu * x[0]:
        return x
    if mu * tangential <= -x[0]:
        return np.zeros(3)
    normal = (x[0] + mu * tangential) / (1 + mu * mu)
    return np.array([normal, *(mu * normal * x[1:] / tangential)])


@pytest.fixture
def pulled(scene):
    """A path whose last increment both sticks and slips, with a slip that has a past."""
    scene["loading"] = {
        "steps": [
            {"approach": "20 um"},
            {"approach": "20 um", "shift_x": "4 um", "shift_y": "1 um", "increments": 2},
        ]
    }
    return scene


def test_a_problem_obeys_its_laws_and_has_the_fields(pulled):
    result = tribosweep.solve(pulled, {"mesh": [12, 10], "tolerance": 1e-12})
    assert 0 < result.stick_elements < result.contact_elements
    problem = result.problem()
    W, q, mu, r, u = (problem[name] for name in ("W", "q", "mu", "r", "u"))
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    assert np.allclose(W, W.T, rtol=1e-12, atol=0) and np.linalg.eigvalsh(W).min() > 0
    assert mu == 0.3 and np.abs(W @ r + q - u).max() < 1e-14 * np.abs(q).max()
    for c, (force, displacement) in enumerate(
        (("pressure", "gap"), ("traction_x", "slip_x"), ("traction_y", "slip_y"))
    ):
        forces = getattr(result, force).ravel()[problem["elements"]] * area
        assert np.allclose(r[c::3], forces, rtol=1e-12, atol=0)
        moved = getattr(result, displacement).ravel()[problem["elements"]]
        assert np.abs(u[c::3] - moved).max() < 1e-11 * np.abs(q).max()
    largest = np.abs(u).max()
    assert r[0::3].min() >= 0 and u[0::3].min() > -1e-11 * largest
    assert np.abs(r[0::3] * u[0::3]).max() < 1e-11 * r.max() * largest
    slides = (result.state.ravel()[problem["elements"]] == 3).nonzero()[0]
    for e in slides:
        slip, force = u[3 * e + 1 : 3 * e + 3], r[3 * e + 1 : 3 * e + 3]
        assert slip @ force == pytest.approx(-mu * r[3 * e] * np.linalg.norm(slip), rel=1e-9)


def test_any_increment_can_be_asked_for(pulled):
    result = tribosweep.solve(pulled, {"mesh": 8})
    whole = tribosweep.Study({"name": "p", "scene": pulled, "numerics": {"mesh": 8}})
    loads = [result.problem(increment)["r"] for increment in (1, 2, 3)]
    # The pull along x begins after the first.
    pulls = [forces[1::3].sum() / forces[0::3].sum() for forces in loads]
    assert abs(pulls[0]) < 1e-6 < 0.01 < pulls[1] < pulls[2]
    assert np.array_equal(loads[2], result.problem()["r"])
    for wrong, words in ((0, "counted from 1"), (4, "the path has 3")):
        with pytest.raises(tribosweep.Error, match=words):
            result.problem(wrong)
    assert whole.points == 1


def test_a_problem_of_a_stored_result_is_that_of_its_record(pulled, store, tmp_path):
    study = {"name": "pulled", "scene": pulled, "numerics": {"mesh": 8}}
    key = tribosweep.Study(study).run(store).results.query(select="key").key[0]
    opened = tribosweep.open(store)
    problem = opened.problem(key[:12])
    assert np.array_equal(problem["r"], tribosweep.solve(study).problem()["r"])
    file = tmp_path / "stored.hdf5"
    opened.fclib(key[:12], file)
    W, q, mu, r, u = read(file)
    assert np.array_equal(W, problem["W"]) and np.array_equal(q, problem["q"])
    assert np.array_equal(r, problem["r"]) and np.array_equal(u, problem["u"])
    assert (mu == 0.3).all() and len(mu) == 64
    assert os.listdir(tmp_path).count("stored.hdf5.part") == 0


def test_a_solver_of_its_own_agrees_with_the_file(pulled, tmp_path):
    file = tmp_path / "sphere.hdf5"
    tribosweep.solve(pulled, {"mesh": 8, "tolerance": 1e-12}).fclib(file)
    W, q, mu, r, _ = read(file)
    # From nothing, so that the solution in the file helps nowhere.
    found = gauss_seidel(W, q, mu, np.zeros_like(r))
    assert np.abs(found - r).max() < 1e-8 * np.abs(r).max()


@pytest.mark.parametrize(
    "name, change",
    [
        ("pulled", {}),
        ("average", {"numerics": {"projection": "average"}}),
        ("epsilon", {"numerics": {"epsilon": 1e-3}}),
        (
            "forces",
            {"loading": {"steps": [{"normal_force": "1 kN"}, {"force_x": "150 N"}]}},
        ),
        ("frictionless", {"friction": {"mu": 0.0}}),
        (
            "layer",
            {
                "foundation": {
                    "layers": [{"shear_modulus": "8 GPa", "poisson": 0.4, "thickness": "0.5 mm"}],
                    "base": {"shear_modulus": "80 GPa", "poisson": 0.3},
                }
            },
        ),
    ],
)
def test_siconos_reads_the_file_and_agrees(pulled, tmp_path, name, change):
    pytest.importorskip("h5py")
    import siconos_packages

    here = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "siconos"
    root, program = here / "packages", here / "fclib_siconos"
    source = ROOT / "python/tests/fclib_siconos.c"
    reason = siconos_packages.unpack(root)
    reason = reason or siconos_packages.compile_program(root, source, program, ["fclib"])
    if reason:
        pytest.skip(f"Siconos cannot be had: {reason}")
    numerics = {"mesh": 12, "tolerance": 1e-12, **change.get("numerics", {})}
    changed = {table: keys for table, keys in change.items() if table != "numerics"}
    file = tmp_path / f"{name}.hdf5"
    tribosweep.solve({**pulled, **changed}, numerics).fclib(file)
    done = subprocess.run(
        [program, file],
        env={**os.environ, "LD_LIBRARY_PATH": siconos_packages.search_path(root)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    # Siconos may warn on standard output before.
    said = json.loads(done.stdout.strip().splitlines()[-1])
    assert said["failed"] == 0 and said["contacts"] == 144, said
    assert said["forces_apart"] < 1e-8 and said["displacements_apart"] < 1e-8, said


def test_what_cannot_be_written_is_said_in_words(scene, tmp_path, monkeypatch):
    result = tribosweep.solve(scene, {"mesh": 96})
    with pytest.raises(tribosweep.Error, match="a mesh of 87 × 87 fits"):
        result.problem()
    result = tribosweep.solve(scene, {"mesh": 8, "ceiling": "1 GPa"})
    assert result.ceiling_elements > 0
    with pytest.raises(tribosweep.Error, match="the ceiling on the pressure is active"):
        result.problem()
    pytest.importorskip("h5py")
    result = tribosweep.solve(scene, {"mesh": 8})
    with pytest.raises(tribosweep.Error, match="cannot write"):
        result.fclib(tmp_path / "nowhere" / "problem.hdf5")
    original = builtins.__import__

    def without_h5py(name, *rest, **named):
        if name == "h5py":
            raise ImportError(name)
        return original(name, *rest, **named)

    monkeypatch.setattr(builtins, "__import__", without_h5py)
    with pytest.raises(ImportError, match="pip install h5py"):
        result.fclib(tmp_path / "problem.hdf5")
