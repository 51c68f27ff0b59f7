r"""
Modulus and work of adhesion of a gel that sticks
=================================================

The bead sticks to the gel and is torn off. A fit with JKR theory on the true layer gives modulus and work of adhesion together; a
fit without adhesion, or on a half-space, gives neither. The curve is shipped as ``examples/fit/sticky_gel.csv``; it is synthetic,
with 4 kPa and 0.2 mJ/m².

On the command line: ``flatpunch fit examples/fit/sticky_gel.csv examples/fit/sticky_gel.toml --plot sticky.png``.
"""

import matplotlib.pyplot as plt

import flatpunch as fp
from flatpunch.fits import read_fit_case

shipped = fp.files.shipped_cases()[0].parent / "fit"
case = read_fit_case(shipped / "sticky_gel.toml")
curve = fp.read_curve(shipped / "sticky_gel.csv", **case.reading)
result = fp.fit(curve, case.medium, case.indenter, case.free, **case.arguments)
print(result.summary())

# %%
# What is fitted is the retract; points of the approach before the contact are left out.

figure, axes = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
fp.plot_fit(result, axes)
plt.show()
