"""Holds the answer of a study of sensitivity against SALib on the same points.

    check-sensitivity.py STUDY.toml ROWS.json ANSWER.json

The rows are in the order of the design, which is SALib's: for each row A, AB_1 … AB_k, B; for each
trajectory its points. Numbers may differ by rounding alone.
"""

import json
import sys
from importlib.metadata import version

import numpy as np
from SALib.analyze import morris, sobol

TOLERANCE = 1e-10


def agree(found, expected, what):
    """Fails if numbers differ by more than rounding from the expected ones."""
    scale = np.abs(expected).max()
    if not np.allclose(found, expected, rtol=0, atol=TOLERANCE * scale):
        sys.exit(f"{what}: {found} where SALib has {list(expected)}")
    return len(expected)


def places(values, levels):
    """Returns the places of values on the grid of a Morris design, by their order."""
    distinct = np.unique(values)
    # Values of one level differ by the rounding of their distribution at most.
    if len(distinct) != levels:
        sys.exit(f"{len(distinct)} values where {levels} levels were expected")
    return np.searchsorted(distinct, values) / (levels - 1)


def main(study, rows_file, answer_file):
    """Compares every table of the answer, and says how many numbers agree."""
    rows = json.load(open(rows_file))["rows"]
    answers = json.load(open(answer_file))["answers"]
    prefix, compared = "sensitivity of ", 0
    for title, table in answers.items():
        if not title.startswith(prefix):
            continue
        name = title.removeprefix(prefix)
        outputs = np.array([row[name] for row in rows], dtype=float)
        # The table is ranked, and the rows of the study have the keys in their order.
        ranked = {row["input"]: row for row in table["rows"]}
        inputs = [column for column in rows[0] if column in ranked]
        problem = {"num_vars": len(inputs), "names": inputs, "bounds": [[0, 1]] * len(inputs)}
        if "S1" in table["rows"][0]:
            expected = sobol.analyze(problem, outputs, calc_second_order=False, seed=1)
            names = {"S1": "S1", "ST": "ST"}
        else:
            points = [[row[column] for row in rows] for column in inputs]
            points = np.column_stack([places(np.array(values), 4) for values in points])
            expected = morris.analyze(problem, points, outputs, num_levels=4, seed=1)
            names = {"mu": "mu", "mu_star": "mu_star", "sigma": "sigma"}
        for ours, theirs in names.items():
            found = np.array([ranked[column][ours] for column in inputs])
            compared += agree(found, np.asarray(expected[theirs]), f"{study}: {ours} of {name}")
    if not compared:
        sys.exit(f"{study}: nothing was compared")
    print(f"{study}: {compared} numbers are those of SALib {version('SALib')} to rounding")


if __name__ == "__main__":
    main(*sys.argv[1:])
