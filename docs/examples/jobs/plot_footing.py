r"""
A rigid footing on layered soil: stiffness, settlement, pressure
================================================================

A flat punch on layers is also a rigid round footing on a soil. Of interest are the spring that stands for the ground, K =
force/settlement, the settlement under the dead load, and the pressure under the base. Engineers take K from a formula for one
stratum on rock, :math:`4 G R/(1 - \nu)\,(1 + 1.28\,R/H)` (E. Kausel 1974; G. Gazetas, Soil Dynamics and Earthquake Engineering
2, 2 (1983)). Published tables of the exact factor are those for cartilage on bone, the same problem (W. C. Hayes and others,
J. Biomech. 5, 541 (1972)).
"""

import csv
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

# %%
# One stratum on rock: the exact factor, the table, the formula.

path = Path("../../../tests/data/hayes1972_flat_punch.csv")
with path.open(encoding="utf-8") as stream:
    rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))

_, axes = plt.subplots(figsize=(5, 4), layout="constrained")
ratio = np.linspace(0.02, 1.0, 30)
for nu, colour in zip((0.3, 0.45, 0.5), ("#440154", "#31688e", "#35b779"), strict=True):
    stratum = fp.Medium([fp.Layer(young=20e6, poisson=nu, thickness=1.0)], base=fp.RigidBase())
    axes.plot(
        ratio, [fp.flat_punch(stratum, a).normalized_stiffness for a in ratio], color=colour, label=rf"$\nu = {nu}$"
    )
    printed = np.array([(row["a_over_h"], row["kappa_hayes"]) for row in rows if float(row["nu"]) == nu], dtype=float)
    axes.plot(*printed[printed[:, 0] <= 1].T, "o", color=colour, mfc="w", ms=4)
axes.plot(ratio, 1 + 1.28 * ratio, "k--", lw=1, label="formula")
axes.set_xlabel("$R/H$")
axes.set_ylabel(r"$K (1 - \nu)/(4 G R)$")
axes.legend(frameon=False)
axes.set_title("lines: exact, circles: table", fontsize=10)
for nu in (0.3, 0.45, 0.5):
    stratum = fp.Medium([fp.Layer(young=20e6, poisson=nu, thickness=12.0)], base=fp.RigidBase())
    off = (1 + 1.28 * 6 / 12) / fp.flat_punch(stratum, 6.0).normalized_stiffness - 1
    print(f"R = 6 m, H = 12 m, nu = {nu}: the formula is off by {off:+.1%}")

# %%
# A site that the formula does not know: a crust of 3 m on 9 m of soft clay, loaded faster than it drains, on gravel. A silo of
# radius 6 m and 10 MN stands on it. On clay from the top it would settle 1.7 times as far; the crust carries the load near the
# rim. The grey line is the mean pressure.

CRUST, CLAY = fp.Layer(60e6, 0.35, 3.0), fp.Layer(10e6, 0.5, 9.0)
GRAVEL = fp.HalfSpace(200e6, 0.25)
RADIUS, LOAD = 6.0, 10e6
_, axes = plt.subplots(figsize=(5, 4), layout="constrained")
r = np.linspace(0, 0.98 * RADIUS, 200)
for name, medium, colour in (
    ("crust, clay, gravel", fp.Medium([CRUST, CLAY], GRAVEL), "#1f4e79"),
    ("clay alone, gravel", fp.Medium([fp.Layer(10e6, 0.5, 12.0)], GRAVEL), "#c1121f"),
):
    footing = fp.flat_punch(medium, RADIUS)
    settlement = LOAD / footing.stiffness
    axes.plot(r, footing.pressure(r) * settlement / 1e3, color=colour, label=name)
    print(f"{name}: K = {footing.stiffness / 1e6:.0f} MN/m, settlement {settlement * 1e3:.1f} mm")
axes.axhline(LOAD / (np.pi * RADIUS**2) / 1e3, color="0.6", lw=0.8)
axes.set_xlabel("distance from the axis (m)")
axes.set_ylabel("pressure (kPa)")
axes.set_ylim(0, 250)
axes.legend(frameon=False)
plt.show()
