"""
Contact outline under a pyramid: Forsbach and Willert 2023, figure 10
=====================================================================

A square pyramid on a layer as thick as the contact is wide. The grey cells are in contact in a boundary element solution; the
first-order outline is the paper's. ``flatpunch paper`` makes all figures of that paper.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

tip = fp.Pyramid(sides=4, inclination=np.pi / 4)
figure, panels = plt.subplots(1, 2, figsize=(8, 4.2), layout="constrained", sharex=True, sharey=True)
for axes, bonded in zip(panels, (False, True), strict=True):
    layer = fp.Medium([fp.Layer(0.75, 0.5, 1.0, bonded=bonded)], base=fp.RigidBase())
    curves = {name: fp.indent(layer, tip, radius=1.0, method=name) for name in ("first-order", "second-order")}
    depth = float(curves["second-order"].depth[0])
    exact = fp.indent(layer, tip, depth=depth, method="bem", grid=160, fields=True)
    x, y = exact.x / depth, exact.y / depth
    axes.pcolormesh(x, y, np.where(exact.contact[0], 0.78, np.nan), cmap="gray", vmin=0, vmax=1)
    for (name, curve), style in zip(curves.items(), ("C3-", "C0--"), strict=True):
        a = np.append(curve.contour[0], curve.contour[0, 0]) / float(curve.depth[0])
        phi = np.append(curve.phi, 2 * np.pi)
        axes.plot(a * np.cos(phi), a * np.sin(phi), style, label=name)
    axes.set_aspect("equal")
    axes.set_title("bonded, incompressible" if bonded else "unbonded")
    axes.set_xlabel(r"$x\,\tan\alpha/d$")
panels[0].set_ylabel(r"$y\,\tan\alpha/d$")
panels[0].legend(loc="center", frameon=False)
