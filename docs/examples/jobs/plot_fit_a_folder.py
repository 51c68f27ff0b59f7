r"""
Fit a folder of curves
======================

Nine places of a gel of known thickness on glass, one file each. Every curve is fitted with the exact contact of the layer on its
base. A curve that cannot be evaluated is a row with a reason, and the others go on. The files are shipped in
``examples/fit/gel_map``; they are synthetic, so that the answer is known: moduli scatter by a fifth about 2.6 kPa.

On the command line: ``flatpunch fit examples/fit/gel_map examples/fit/thin_gel.toml -o table.csv --plot map.png``.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp
from flatpunch.fits import read_fit_case

shipped = fp.files.shipped_cases()[0].parent / "fit"
case = read_fit_case(shipped / "thin_gel.toml")
files = sorted((shipped / "gel_map").glob("*.csv"))
batch = fp.fit_batch(files, case.medium, case.indenter, case.free, workers=1)

# %%
# The table has a row for each curve: values, intervals, and the reason where there is none.

name = "layers[0].young"
for row in batch.rows:
    if row["ok"]:
        low, high = (row[f"{name} {end}"] / 1e3 for end in ("low", "high"))
        print(f"{row['curve']}: {row[name] / 1e3:.2f} kPa, 95 % within {low:.2f} to {high:.2f}")
    else:
        print(f"{row['curve']}: {row['reason']}")

# %%
# Modulus of each curve, and what the same curves give if the gel is taken for a half-space.

figure, axes = plt.subplots(figsize=(6.4, 4), layout="constrained")
fp.plot_fit(batch, axes)
thick = fp.fit_batch(files, fp.HalfSpace(case.medium.layers[0].young, 0.5), case.indenter, ["base.young"], workers=1)
number = np.arange(1, len(files) + 1)
good = [bool(row["ok"]) for row in thick.rows]
young = np.array([row["base.young"] if row["ok"] else np.nan for row in thick.rows])
axes.plot(
    number[good], young[good] / 1e3, "s", color="#c8590a", markerfacecolor="white", label="taken for a half-space"
)
axes.plot([], [], "o", color="#0b4f86", label="layer on glass")
axes.legend(loc="center left")
plt.show()
