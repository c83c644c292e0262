#!/usr/bin/env python3
"""Writes crates/contact/tests/reference/layer_kernels.csv; needs mpmath, takes minutes.

    python3 scripts/layer_kernels.py

The table has the radial functions of the surface kernels of layered foundations, r times
  N = ∫ F_NN J0(kr) dk, A = ∫ (F_LL + F_TT)/2 J0 dk, B = ∫ (F_LL - F_TT)/2 J2 dk,
  M = ∫ F_LN J1 dk,  F = k C(k),
by brute force in 30 digits. The half-space of the top layer is integrated analytically. The rest,
which ends at k h1 = 30, is integrated by Gauss rules on octaves of k cut into pieces of at most
half a wave. The compliance is that of layer_compliance.py.
"""

from pathlib import Path
from mpmath import mp, mpf, besselj, pi, nstr
from mpmath.calculus.quadrature import GaussLegendre
from layer_compliance import compliance, parse

STACKS = [
    ("coating_stiff", "10;0.3;0.5", "1;0.3", "0.01 0.3 0.499 0.501 2 9"),
    ("three_layer", "5;0.2;0.1 0.5;0.4;0.3 2;0.3;0.05", "1;0.35", "0.005 0.09 0.4 3"),
    ("rigid_base_incompressible", "1;0.5;1", "rigid", "0.02 0.7 1.5 4 9"),
    ("soft_on_hard", "1e-6;0.45;0.01", "1;0.3", "0.004 0.02 0.1 0.3"),
    ("hard_on_soft", "1e8;0.3;0.01", "1;0.3", "0.005 0.05 0.3"),
    ("plate_on_squeezed_film", "1e4;0.3;0.1 1e-4;0.5;0.01", "rigid", "0.03 0.2 1 3"),
    ("two_scales", "1;0.3;0.01 10;0.2;10", "1;0.3", "0.005 0.02 0.5"),
]


def pieces(lowest, highest, longest):
    a, b = mpf(0), lowest
    while a < highest:
        n = int(mp.ceil((b - a) / longest))
        for i in range(n):
            yield a + (b - a) * i / n, a + (b - a) * (i + 1) / n
        a, b = b, min(2 * b, highest)


def kernels(layers, base, radii):
    mp.dps = 30
    rule = GaussLegendre(mp).calc_nodes(4, mp.prec)  # The rule has 24 nodes.
    g, nu, thickness = layers[0]
    top = [(1 - nu) / g, (1 - nu / 2) / g, -nu / 2 / g, (nu - mpf(1) / 2) / g]
    stiffness = [m[0] for m in layers + ([base] if base else [])]
    widest = sum(h for _, _, h in layers) * max(stiffness) / min(stiffness)
    sums = [[mpf(0)] * 4 for _ in radii]
    for a, b in pieces(mpf(1) / 1000 / widest, 30 / thickness, pi / max(radii)):
        for node, weight in rule:
            k, w = (a + b) / 2 + (b - a) / 2 * node, (b - a) / 2 * weight
            ll, ln, nn, tt = (k * c for c in compliance(layers, base, k))
            mp.dps = 30
            f = [v - t for v, t in zip((nn, (ll + tt) / 2, (ll - tt) / 2, ln), top)]
            for r, total in zip(radii, sums):
                j0, j1 = besselj(0, k * r), besselj(1, k * r)
                j2 = besselj(2, k * r)
                for i, j in enumerate((j0, j0, j2, j1)):
                    total[i] += w * f[i] * j
    return [[t + r * s for t, s in zip(top, total)] for r, total in zip(radii, sums)]


def main():
    path = (
        Path(__file__).resolve().parent.parent / "crates/contact/tests/reference/layer_kernels.csv"
    )
    with open(path, "w") as out:
        print("case,layers(G;nu;h top to bottom),base(G;nu or rigid),r,rN,rA,rB,rM", file=out)
        for name, stack, base, radii in STACKS:
            distances = [mpf(float(r)) for r in radii.split()]
            for r, values in zip(radii.split(), kernels(*parse(stack, base), distances)):
                print(
                    name,
                    stack,
                    base,
                    r,
                    *(nstr(v, 18, min_fixed=0, max_fixed=0) for v in values),
                    sep=",",
                    file=out,
                    flush=True,
                )


if __name__ == "__main__":
    main()
