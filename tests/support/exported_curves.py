"""A curve of approach and retract in the columns that instruments export, and what is read from them."""

import numpy as np

N, K, SENSITIVITY = 60, 0.05, 60e-9
DEPTH = np.linspace(-3e-7, 2e-7, N)
FORCE = 1e-9 * (np.maximum(DEPTH, 0) / 1e-7) ** 1.5
BACK = 0.7 * FORCE[::-1]
DEFLECTION = FORCE / K
PIEZO = DEPTH + DEFLECTION
TIME = 0.01 * np.arange(N)
COLUMNS = {
    "d": DEPTH * 1e9,
    "D": DEPTH[::-1] * 1e9,
    "f": FORCE * 1e9,
    "F": BACK * 1e9,
    "z": PIEZO * 1e9,
    "Z": (DEPTH[::-1] + BACK / K) * 1e9,
    "v": DEFLECTION / SENSITIVITY,
    "V": BACK / K / SENSITIVITY,
    "c": DEFLECTION * 1e9,
    "C": BACK / K * 1e9,
    "t": TIME,
    "T": TIME[-1] + 0.01 + TIME,
    "i": np.arange(N),
    "0": np.zeros(N),
    "1": np.ones(N),
}
"""Columns of approach (small letters) and retract in the order of time: nm, nN, V, s."""


def rows(columns, sep="\t", decimal=".", turned=False):
    """Lines of columns that are named by their letters; "*word*" is a word in each row."""
    cells = [COLUMNS.get(c, [c.strip("*")] * N) for c in columns]
    lines = [
        sep.join(v if isinstance(v, str) else f"{v:.8g}".replace(".", decimal) for v in row)
        for row in zip(*cells, strict=True)
    ]
    return "\n".join(lines[:: -1 if turned else 1]) + "\n"


def written(path, text, encoding="utf-8"):
    path.write_bytes(text.encode(encoding))
    return path


def holds(curve, depth, force, tolerance=1e-6):
    """The curve has these positions, by whatever sign and from whatever zero, and these forces."""
    assert curve.force.size == force.size
    np.testing.assert_allclose(curve.force, force, rtol=tolerance, atol=tolerance * force.max())
    own, wanted = curve.depth - curve.depth[0], depth - depth[0]
    sign = np.sign(own @ wanted) or 1.0
    np.testing.assert_allclose(sign * own, wanted, atol=10 * tolerance * np.ptp(depth))


APPROACH = (DEPTH, FORCE)
CYCLE = (np.append(DEPTH, DEPTH[::-1]), np.append(FORCE, BACK))
