"""Writes the outputs of small designs with what SALib makes of them:

    pip install SALib==1.5.1 'pandas<3'
    python3 scripts/sensitivity_references.py > crates/answers/src/sensitivity/references.csv

A line has the method, the function, what the numbers are, and the numbers. Outputs are in SALib's
order: for each row A, AB_1 … AB_k, B; for each trajectory its points, as those of the inputs in the
unit cube.
"""

from importlib.metadata import version
from math import pi

import numpy as np
from SALib.analyze import morris as morris_effects
from SALib.analyze import sobol as sobol_indices
from SALib.sample import morris as morris_design
from SALib.sample import sobol as sobol_design


def ishigami(u):
    x = pi * (2 * u - 1)
    return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def hertz(u):
    """The peak pressure below a sphere [Pa] for loads, moduli and radii of uniform logarithms."""
    force, modulus, radius = (10 * 100 ** u[:, 0], 1e9 * 100 ** u[:, 1], 1e-3 * 10 ** u[:, 2])
    return (6 * force * modulus**2 / (pi**3 * radius**2)) ** (1 / 3)


def line(*cells):
    print(",".join(cell if isinstance(cell, str) else repr(float(cell)) for cell in cells))


print(f"# SALib {version('SALib')}, numpy {version('numpy')}, scipy {version('scipy')}")
problem = {"num_vars": 3, "names": ["x1", "x2", "x3"], "bounds": [[0, 1]] * 3}
for function in [ishigami, hertz]:
    points = sobol_design.sample(problem, 16, calc_second_order=False, seed=7)
    outputs = function(points)
    indices = sobol_indices.analyze(problem, outputs, calc_second_order=False, seed=7)
    line("sobol", function.__name__, "outputs", *outputs)
    line("sobol", function.__name__, "S1", *indices["S1"])
    line("sobol", function.__name__, "ST", *indices["ST"])
for function, levels in [(ishigami, 4), (hertz, 8)]:
    points = morris_design.sample(problem, 5, num_levels=levels, seed=7)
    outputs = function(points)
    effects = morris_effects.analyze(problem, points, outputs, num_levels=levels, seed=7)
    line("morris", function.__name__, "points", *points.flatten())
    line("morris", function.__name__, "outputs", *outputs)
    for name in ["mu", "mu_star", "sigma"]:
        line("morris", function.__name__, name, *effects[name])
