r"""
Radius and force under a pyramid: Forsbach and Willert 2023, figures 11 and 12
==============================================================================

A square pyramid on an unbonded layer. The depth is over its largest value, the thickness over the radius
:math:`a_\infty` that the largest depth gives on a half-space, and the force over the largest half-space force. Lines
are the paper's method, markers boundary elements.

The paper normalises forces without saying by which half-space solution. With that of the same method, as here, the
lines meet the markers within 2 %. At given depth the first-order force itself is 4 to 6 % low.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

tip = fp.Pyramid(sides=4, inclination=np.radians(20))
space = fp.HalfSpace(young=0.75, poisson=0.5)
largest = 1.0
lines, marks = np.linspace(0.02, 1, 50) * largest, np.array([0.25, 0.5, 0.75, 1.0]) * largest
reference = {m: fp.indent(space, tip, depth=largest, method=m, angles=60) for m in ("first-order", "bem")}

figure, (radii, forces) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
for ratio, colour in zip((0.25, 0.5, 1, 2, 5), plt.cm.viridis(np.linspace(0, 0.85, 5)), strict=True):
    thickness = ratio * float(reference["first-order"].radius[0])
    layer = fp.Medium([fp.Layer(0.75, 0.5, thickness, bonded=False)], base=fp.RigidBase())
    line = fp.indent(layer, tip, depth=lines, method="first-order", angles=60)
    mark = fp.indent(layer, tip, depth=marks, method=fp.BoundaryElements(grid=96), angles=60)
    radii.semilogy(lines, line.radius / thickness, color=colour, label=rf"$h/a_\infty = {ratio:g}$")
    radii.plot(marks, mark.radius / thickness, "o", color=colour, mfc="w")
    forces.semilogy(lines, line.force / float(reference["first-order"].force[0]), color=colour)
    forces.plot(marks, mark.force / float(reference["bem"].force[0]), "o", color=colour, mfc="w")
radii.set_ylabel("$a_0/h$")
forces.set_ylabel("force / largest half-space force")
for axes in (radii, forces):
    axes.set_xlabel(r"$d/d_\mathrm{max}$")
radii.legend(frameon=False, ncols=2, fontsize=8)
