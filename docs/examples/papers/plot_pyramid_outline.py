r"""
Contact outline under a pyramid: Forsbach and Willert 2023, figure 10
=====================================================================

A square pyramid on a layer as thick as the contact's mean radius, :math:`h = a_0`. The grey cells are in contact in a
boundary element solution. The red outline is the paper's: good along the sides and short at the corners, less so on the
bonded incompressible layer, as the paper says. Second order overshoots the corners instead, `refined` meets them.
``flatpunch paper`` makes all figures of that paper.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

tip = fp.Pyramid(sides=4, inclination=np.radians(20))
slope = np.tan(np.radians(20))
styles = {"first-order": "C3-", "second-order": "C0--", "refined": "k:"}
figure, panels = plt.subplots(1, 2, figsize=(8.4, 4.6), layout="constrained", sharex=True, sharey=True)
for axes, bonded in zip(panels, (False, True), strict=True):
    layer = fp.Medium([fp.Layer(0.75, 0.5, 1.0, bonded=bonded)], base=fp.RigidBase())
    depth = float(fp.indent(layer, tip, radius=1.0, method="first-order").depth[0])
    exact = fp.indent(layer, tip, depth=depth, method=fp.BoundaryElements(grid=160, fields=True))
    scale = slope / depth
    cells = np.where(exact.contact[0], 0.8, np.nan)
    axes.pcolormesh(exact.x * scale, exact.y * scale, cells, cmap="gray", vmin=0, vmax=1)
    for name, style in styles.items():
        curve = fp.indent(layer, tip, depth=depth, method=name)
        a, phi = np.append(curve.contour[0], curve.contour[0, 0]) * scale, np.append(curve.phi, 2 * np.pi)
        axes.plot(a * np.cos(phi), a * np.sin(phi), style, lw=1.4, label=name)
    axes.set_aspect("equal")
    axes.set_title("bonded, incompressible" if bonded else "unbonded")
    axes.set_xlabel(r"$x\,\tan\alpha/d$")
panels[0].set_ylabel(r"$y\,\tan\alpha/d$")
panels[0].legend(loc="center", frameon=False)
