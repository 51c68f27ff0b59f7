r"""
Flat punch on cartilage: Hayes et al. 1972
==========================================

The table by which indentation of cartilage has been evaluated for fifty years (W. C. Hayes and others, J. Biomech. 5,
541): the factor of a cylindrical flat punch on a bonded layer over a/h. Here it is computed again. On incompressible
layers the printed values are up to 6 % low under wide punches.
"""

import csv
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

# %%
# The exact factor is the normalised stiffness of the flat punch, :math:`\bar K = F/(2 E^* a d)`.

ratio = np.geomspace(0.15, 9, 25)


def factor(poisson, radius):
    """Kbar over a/h for one Poisson ratio."""
    layer = fp.Medium([fp.Layer(young=1.0, poisson=poisson, thickness=1.0)], base=fp.RigidBase())
    return np.array([fp.flat_punch(layer, a).normalized_stiffness for a in radius])


# %%
# The published table, as transcribed in public code.

path = Path("../../../tests/data/hayes1972_flat_punch.csv")
with path.open(encoding="utf-8") as stream:
    rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))

figure, (axes, errors) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for nu, colour in zip((0.3, 0.4, 0.45, 0.5), ("#440154", "#31688e", "#35b779", "#d9b400"), strict=True):
    chosen = [row for row in rows if float(row["nu"]) == nu]
    x = np.array([float(row["a_over_h"]) for row in chosen])
    printed = np.array([float(row["kappa_hayes"]) for row in chosen])
    axes.loglog(ratio, factor(nu, ratio), color=colour, label=rf"$\nu = {nu}$")
    axes.plot(x, printed, "o", color=colour, mfc="w", ms=4)
    errors.semilogx(x, 100 * (printed / factor(nu, x) - 1), "o-", color=colour, ms=4, lw=0.8)
axes.set_ylabel(r"$\bar K$")
axes.set_title("lines: exact, markers: Hayes et al.", fontsize=10)
axes.legend(frameon=False)
errors.set_title("error of the table (%)", fontsize=10)
for panel in (axes, errors):
    panel.set_xticks([0.2, 0.5, 1, 2, 5], ["0.2", "0.5", "1", "2", "5"])
    panel.minorticks_off()
    panel.set_xlabel("$a/h$")
