r"""
Modulus and relaxation of a cell from one curve
===============================================

Half a second down, four seconds of hold, one back: the force over time of the whole history is fitted, so that the modulus at the
first moment, the relaxation time and the modulus that remains come from one curve. The curve is shipped as
``examples/fit/relaxing_cell.csv``; it is synthetic: 2 kPa at first, of which 0.35 remain, with a relaxation time of 0.8 s.

On the command line: ``flatpunch fit examples/fit/relaxing_cell.csv examples/fit/relaxing_cell.toml --plot relaxing.png``.
"""

import matplotlib.pyplot as plt

import flatpunch as fp
from flatpunch.fits import read_fit_case

shipped = fp.files.shipped_cases()[0].parent / "fit"
case = read_fit_case(shipped / "relaxing_cell.toml")
curve = fp.read_curve(shipped / "relaxing_cell.csv", **case.reading)
result = fp.fit(curve, case.medium, case.indenter, case.free, **case.arguments)
print(result.summary())

figure, (force, residual) = plt.subplots(
    2, 1, figsize=(6.4, 5), sharex=True, height_ratios=(3, 1), layout="constrained"
)
fp.plot_fit(result, force)
fp.plot_fit(result, residual, residuals=True)
force.set_xlabel("")
plt.show()
