r"""
Cell on glass: ramp, hold, retract
==================================

A living cell relaxes by a power law of time. Pressed with a sphere in a second, held for five, released in a second, its
force is the memory integral of Lee and Radok while the contact grows and Ting's construction while it shrinks. The case
is shipped as ``examples/cell_ramp_hold_retract.toml``; its text says where the values come from.

On a thick sample the ramp has a closed form: with :math:`E \propto t^{-\alpha}` and :math:`d = vt`, the force of a
paraboloid is :math:`\frac43 E^*\sqrt R\,(vt)^{3/2}\,(t/t_0)^{-\alpha}\,\frac{3}{2}\mathrm{B}(\tfrac32, 1-\alpha)`
(markers). A cell of 4 µm on glass is stiffer, and who evaluates it as thick finds another modulus at every time of the
hold; the exponent of the relaxation stays what it is.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import beta

import flatpunch as fp

case = fp.read_case(next(path for path in fp.files.shipped_cases() if path.stem == "cell_ramp_hold_retract"))
cell, law = case.medium.layers[0], case.physics.relaxation
radius = case.indenter.radius
time = np.concatenate([np.linspace(0, 1, 101), np.linspace(1, 6, 101)[1:], np.linspace(6, 7, 201)[1:]])
depth = np.interp(time, [0, 1, 6, 7], [0, 500e-9, 500e-9, 0])

figure, (over_time, over_depth) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
thick = fp.HalfSpace(cell.young, cell.poisson)
for medium, label, colour in ((case.medium, "4 µm on glass", "C0"), (thick, "thick", "0.55")):
    history = fp.indent(medium, fp.Paraboloid(radius), time=time, depth=depth, relaxation=law)
    over_time.plot(time, history.force * 1e9, color=colour, label=label)
    over_depth.plot(depth * 1e9, history.force * 1e9, color=colour)
    hold = (time > 2) & (time < 6)
    slope = np.polyfit(np.log(time[hold]), np.log(history.force[hold]), 1)[0]
    print(f"{label}: {float(history.force.max()) * 1e9:.2f} nN at the top, then falling like t^{slope:.3f}")

ramp = np.linspace(0.1, 1, 7)
modulus = cell.young / (1 - cell.poisson**2)
closed = 4 / 3 * modulus * np.sqrt(radius) * (500e-9 * ramp) ** 1.5 * (ramp / law.time) ** -law.exponent
closed *= 1.5 * beta(1.5, 1 - law.exponent)
over_time.plot(ramp, closed * 1e9, "o", color="0.4", mfc="w", ms=4, label="closed form")
over_time.set_xlabel("time (s)")
over_time.set_ylabel("force (nN)")
over_time.legend(frameon=False)
over_depth.set_xlabel("depth (nm)")
