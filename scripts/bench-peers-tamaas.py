"""Solves a frictionless sphere under a given load with tamaas, for scripts/bench-peers.

    python bench-peers-tamaas.py N LOAD TOLERANCE

The scene has R = 1, G = 1, nu = 0.3 and a square of side 3 (three Hertz radii for the load that
gives an approach of 1), with N by N elements. Tamaas' own kernel is periodic; `registerNonPeriodic`
gives the half-space's: elements of constant pressure, displacements at their centres.

The script prints the seconds without the interpreter's start and imports, the relative residual of
the natural map as tribosweep's certificate defines it (tamaas' TOLERANCE is a complementarity of
its own), and the approach.
"""

import json
import sys
from math import asinh, pi
from time import perf_counter

import numpy as np
import tamaas as tm

SHEAR_MODULUS, POISSON, SIDE = 1.0, 0.3, 3.0


def main(n, load, tolerance):
    tm.initialize(1)
    tm.set_log_level(tm.LogLevel.error)
    start = perf_counter()
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [SIDE, SIDE], [n, n])
    model.nu = POISSON
    model.E = 2 * SHEAR_MODULUS * (1 + POISSON)
    tm.ModelFactory.registerNonPeriodic(model, "half-space")
    x = (np.arange(n) + 0.5) * SIDE / n - SIDE / 2
    heights = -(x[:, None] ** 2 + x[None, :] ** 2) / 2
    solver = tm.PolonskyKeerRey(model, heights, tolerance)
    solver.setIntegralOperator("half-space")
    solver.max_iter = 5000
    solver.solve(load / SIDE**2)  # The argument is the mean pressure.
    seconds = perf_counter() - start

    p = np.array(model.traction)
    u = np.zeros_like(p)
    model.operators["half-space"](p, u)
    approach = (u - heights)[p > 0].mean()
    gap = u - heights - approach
    diagonal = (1 - POISSON) / (2 * pi * SHEAR_MODULUS) * 4 * (SIDE / n) * asinh(1)
    residual = np.linalg.norm(p - np.maximum(0, p - gap / diagonal)) / np.linalg.norm(p)
    print(json.dumps({"seconds": seconds, "residual": float(residual), "result": float(approach)}))


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3]))
