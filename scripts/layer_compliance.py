#!/usr/bin/env python3
"""Writes crates/contact/tests/reference/layer_compliance_random.csv; needs mpmath.

    python3 scripts/layer_compliance.py

The table has the Fourier compliance of random stacks of one to five layers, with layers of any
thickness in waves and contrasts of stiffness up to 1e12 between neighbours. It comes from transfer
matrices exp(-M k h) of the equations of plane strain, in as many digits as the growing exponentials
and the cancellation in thin layers eat up, with 40 to spare. `--check` compares with the rows of
layer_compliance.csv, which come from another formulation.
"""

import random
import sys
from pathlib import Path
from mpmath import mp, mpf, matrix, eye, cosh, sinh, tanh, nstr, log10

REFERENCE = Path(__file__).resolve().parent.parent / "crates/contact/tests/reference"


def transfer(nu, x):
    """Returns the matrix that takes (U, W, q, p) from the lower face of a layer to the upper one.

    U and W are the displacements along k and along the normal; q and p are the tractions that
    act on the material below, per G k.
    """
    m = 1 - nu
    a, b, c = 2 / m, nu / m, (1 - 2 * nu) / (2 * m)
    lower = matrix([[0, 1, -1, 0], [-b, 0, 0, -c], [-a, 0, 0, b], [0, 0, -1, 0]])
    # Since (M² − 1)² = 0, the exponential is the cubic polynomial in M that meets e^{tx} and its
    # derivative at t = ±1.
    up = -lower
    c3 = (x * cosh(x) - sinh(x)) / 2
    c2 = x * sinh(x) / 2
    square = up * up
    return (cosh(x) - c2) * eye(4) + (sinh(x) - c3) * up + c2 * square + c3 * (square * up)


def compliance(layers, base, k):
    deepest = sum(min(h * k, 400) for _, _, h in layers)
    thinnest = min(h * k for _, _, h in layers)
    contrast = max(abs(log10(m[0])) for m in layers + ([base] if base else []))
    mp.dps = int(60 + 2 * deepest - 8 * min(0, log10(thinnest)) + 8 * contrast)
    k = mpf(k)
    if base:
        g, nu = base[:2]
        c = matrix([[1 - nu, nu - mpf(1) / 2], [nu - mpf(1) / 2, 1 - nu]]) / (g * k)
        across = 1 / (g * k)
    else:
        c, across = matrix(2, 2), mpf(0)
    for g, nu, h in reversed(layers):
        x = min(k * h, mpf(400))  # A factor exp(-800) is not felt.
        p = transfer(nu, x)
        c *= g * k
        u = p[0:2, 0:2] * c + p[0:2, 2:4]
        t = p[2:4, 0:2] * c + p[2:4, 2:4]
        c = u * t**-1 / (g * k)
        across *= g * k
        across = (across + tanh(x)) / (1 + across * tanh(x)) / (g * k)
    return c[0, 0], (c[0, 1] + c[1, 0]) / 2, c[1, 1], across


def parse(layers, base):
    def numbers(text):
        # The values are the doubles that a program reads.
        return tuple(mpf(float(cell)) for cell in text.split(";"))

    return [numbers(layer) for layer in layers.split()], None if base == "rigid" else numbers(base)


def check():
    mp.dps = 30
    worst = mpf(0)
    for line in (REFERENCE / "layer_compliance.csv").read_text().splitlines()[1:]:
        _, layers, base, k, *values = line.split(",")
        if not layers:
            continue
        got = compliance(*parse(layers, base), mpf(float(k)))
        exact = [mpf(v) for v in values]
        unit = [exact[0], (exact[0] * exact[2]) ** 0.5, exact[2], exact[3]]
        worst = max([worst] + [abs(g - e) / u for g, e, u in zip(got, exact, unit)])
    print("largest difference", nstr(worst, 3))


def main():
    if "--check" in sys.argv:
        return check()
    pick = random.Random(20240607)

    def material():
        modulus = f"{10 ** pick.uniform(-6, 6):.6g}"
        return modulus, pick.choice(["0", "0.5", "0.4999999", f"{pick.uniform(0, 0.5):.4f}"])

    with open(REFERENCE / "layer_compliance_random.csv", "w") as out:
        print(
            "case,layers(G;nu;h top to bottom),base(G;nu or rigid),k,C_LL,C_LN,C_NN,C_TT", file=out
        )
        for case in range(240):
            layers = " ".join(
                ";".join(
                    [
                        *material(),
                        f"{10 ** pick.choice([pick.uniform(-9, 2), pick.uniform(-1, 1)]):.6g}",
                    ]
                )
                for _ in range(pick.randint(1, 5))
            )
            base = pick.choice(["rigid", ";".join(material())])
            k = f"{10 ** pick.uniform(-3, 1):.6g}"
            values = compliance(*parse(layers, base), mpf(float(k)))
            print(
                f"random_{case}",
                layers,
                base,
                k,
                *(nstr(v, 18, min_fixed=0, max_fixed=0) for v in values),
                sep=",",
                file=out,
            )


if __name__ == "__main__":
    main()
