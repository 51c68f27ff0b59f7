"""
Flat punch on cartilage: Hayes 1972
===================================

The table by which indentation of cartilage has been evaluated for fifty years: the factor of a cylindrical flat punch on a
bonded layer, over a/h. The printed values are up to 6 % low for wide punches on incompressible layers.
"""

import csv
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

# %%
# The exact factor is the normalised stiffness of the flat punch, Kbar = F/(2 E* a d).

ratio = np.geomspace(0.15, 9, 25)


def factor(poisson):
    """Kbar over a/h for one Poisson ratio."""
    layer = fp.Medium([fp.Layer(young=1.0, poisson=poisson, thickness=1.0)], base=fp.RigidBase())
    return np.array([fp.flat_punch(layer, a).normalized_stiffness for a in ratio])


exact = {nu: factor(nu) for nu in (0.3, 0.4, 0.45, 0.5)}

# %%
# The published table, as transcribed in public code.

path = Path("../../tests/data/hayes1972_flat_punch.csv")
with path.open(encoding="utf-8") as stream:
    rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))

figure, (axes, errors) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for nu, colour in zip(exact, ("#440154", "#31688e", "#35b779", "#d9b400"), strict=True):
    axes.loglog(ratio, exact[nu], color=colour, label=f"$\\nu = {nu}$")
    chosen = [r for r in rows if float(r["nu"]) == nu]
    x = np.array([float(r["a_over_h"]) for r in chosen])
    printed = np.array([float(r["kappa_hayes"]) for r in chosen])
    axes.plot(x, printed, "o", color=colour, mfc="w", ms=4)
    true = np.exp(np.interp(np.log(x), np.log(ratio), np.log(exact[nu])))
    errors.semilogx(x, 100 * (printed / true - 1), "o-", color=colour, ms=4, lw=0.8)
axes.set_xlabel("$a/h$")
axes.set_ylabel(r"$\bar K$")
axes.set_title("lines: exact, markers: Hayes et al. 1972")
axes.legend(frameon=False)
errors.set_xticks([0.2, 0.5, 1, 2, 5], ["0.2", "0.5", "1", "2", "5"], minor=False)
errors.minorticks_off()
errors.set_xlabel("$a/h$")
errors.set_ylabel("error of the table (%)")
