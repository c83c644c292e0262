#!/usr/bin/env python3
"""Writes crates/contact/tests/reference/half_space_integrals.csv; needs mpmath.

    python3 scripts/half_space_integrals.py

The integrals of the half-space's surface kernels between boundary elements are second differences
(average) or differences (midpoint) of antiderivatives in 100-digit arithmetic, where their
cancellation does no harm. `--check` compares the antiderivatives with adaptive quadrature of the
kernels.
"""

import sys
from pathlib import Path
from mpmath import mp, mpf, mpc, log, sqrt, atan, asinh, quad

mp.dps = 100
KERNELS = ["inv_r", "xx", "yy", "xy", "x", "y"]
KERNEL = {
    "inv_r": lambda x, y: 1 / sqrt(x * x + y * y),
    "xx": lambda x, y: x * x / sqrt(x * x + y * y) ** 3,
    "yy": lambda x, y: y * y / sqrt(x * x + y * y) ** 3,
    "xy": lambda x, y: x * y / sqrt(x * x + y * y) ** 3,
    "x": lambda x, y: x / (x * x + y * y),
    "y": lambda x, y: y / (x * x + y * y),
}


def times_log(p, a, b):
    """Returns p ln(a + r), with r the distance of (a, b) from the origin; 0 where p is 0."""
    return p * log(a + sqrt(a * a + b * b)) if p else mpf(0)


def cube_log(x, y):
    z = mpc(x, y)
    return (z**3 * log(z)).real if z else mpf(0)


# Differentiated twice in x and twice in y, these give the kernels.
def f_yy(x, y):
    r = sqrt(x * x + y * y)
    return r**3 / 6 + times_log(x * x * y / 2, y, x) - x * x * r / 2


AVERAGE = {
    "inv_r": lambda x, y: (
        times_log(x * x * y / 2, y, x)
        + times_log(x * y * y / 2, x, y)
        - sqrt(x * x + y * y) ** 3 / 6
    ),
    "xx": lambda x, y: f_yy(y, x),
    "yy": f_yy,
    "xy": lambda x, y: (
        -(x * y * sqrt(x * x + y * y) / 3 + times_log(y**3 / 6, x, y) + times_log(x**3 / 6, y, x))
    ),
    "x": lambda x, y: -cube_log(x, y) / 6,
    "y": lambda x, y: -cube_log(y, x) / 6,
}


def l1(x, y):
    return x * asinh(y / abs(x)) if x else mpf(0)


def half_log(x, y):
    r2 = x * x + y * y
    return (y * log(r2) / 2 if r2 else mpf(0)) + (x * atan(y / x) if x else mpf(0))


# Differentiated once in x and once in y, these give the kernels.
MIDPOINT = {
    "inv_r": lambda x, y: l1(x, y) + l1(y, x),
    "xx": lambda x, y: l1(y, x),
    "yy": l1,
    "xy": lambda x, y: -sqrt(x * x + y * y),
    "x": half_log,
    "y": lambda x, y: half_log(y, x),
}


def average(name, x, y, hx, hy):
    f = AVERAGE[name]
    terms = [(1, -1), (-2, 0), (1, 1)]
    return sum(a * b * f(x + s * hx, y + t * hy) for a, s in terms for b, t in terms) / (hx * hy)


def midpoint(name, x, y, hx, hy):
    f = MIDPOINT[name]
    terms = [(-1, -1), (1, 1)]
    return sum(a * b * f(x + s * hx / 2, y + t * hy / 2) for a, s in terms for b, t in terms)


def value(projection, name, i, j, hx, hy):
    odd_x, odd_y = name in ("xy", "x"), name in ("xy", "y")
    if (i == 0 and odd_x) or (j == 0 and odd_y):
        return mpf(0)
    return projection(name, i * hx, j * hy, hx, hy)


def check():
    mp.dps = 25
    for hx, hy in [(mpf(1), mpf(1)), (mpf("0.3"), mpf(1))]:
        for i, j in [(0, 0), (1, 0), (0, 1), (1, 1), (2, 1), (3, 0)]:
            x, y = i * hx, j * hy
            for name in KERNELS:
                kernel = KERNEL[name]

                def tent(s, t):
                    if s == 0 == t:
                        return mpf(0)
                    return (1 - abs(s - x) / hx) * (1 - abs(t - y) / hy) * kernel(s, t)

                def box(s, t):
                    return kernel(s, t) if s or t else mpf(0)

                def cuts(middle, half):
                    return sorted({middle - half, middle, middle + half})

                mp.dps = 15
                by_quadrature = (
                    quad(tent, cuts(x, hx), cuts(y, hy)),
                    quad(box, cuts(x, hx / 2), cuts(y, hy / 2)),
                )
                mp.dps = 100
                for p, q in zip((average, midpoint), by_quadrature):
                    exact = value(p, name, i, j, hx, hy)
                    print(p.__name__, hx, i, j, name, mp.nstr(exact, 17), mp.nstr(q - exact, 3))


def main():
    if "--check" in sys.argv:
        return check()
    # --dense takes many more offsets, for measuring, and writes them to standard output.
    dense = "--dense" in sys.argv
    sizes = [(1e-3, 1.0), (0.1, 1.0), (1.0, 1.0), (3.0, 1.0), (1e3, 1.0)]
    offsets = [0, 1, 2, 3, 7, 16, 40, 175, 1700, 4096]
    if dense:
        sizes += [(0.01, 1.0), (0.5, 1.0), (10.0, 1.0), (100.0, 1.0), (1.0, 3.0)]
        offsets = [
            0,
            1,
            2,
            3,
            4,
            5,
            6,
            8,
            10,
            13,
            17,
            20,
            24,
            30,
            38,
            39,
            55,
            80,
            120,
            159,
            160,
            250,
            400,
            640,
            900,
        ]
        offsets += [1200, 1600, 1700, 2000, 2600, 2858, 2859, 3300, 4096]
    path = (
        Path(__file__).resolve().parent.parent
        / "crates/contact/tests/reference/half_space_integrals.csv"
    )
    with sys.stdout if dense else open(path, "w") as out:
        print("projection,hx,hy,di,dj," + ",".join(KERNELS), file=out)
        for projection in (average, midpoint):
            for hx, hy in sizes:
                for i in offsets:
                    for j in offsets:
                        row = [value(projection, name, i, j, mpf(hx), mpf(hy)) for name in KERNELS]
                        print(
                            projection.__name__,
                            hx,
                            hy,
                            i,
                            j,
                            *(mp.nstr(v, 18) for v in row),
                            sep=",",
                            file=out,
                        )


main()
