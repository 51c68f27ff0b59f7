"""
Contact eccentricity on thin layers: Forsbach and Willert 2023, figures 2 to 5
==============================================================================

An elliptic paraboloid makes a contact that is slenderer than its own level lines on a half-space, and on bonded
incompressible layers rounder once they are thin. One cut through the maps of the paper, at e_g = 0.6.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

e_g = 0.6
tip = fp.EllipticParaboloid(A=1 - e_g**2, B=1.0)
log_thickness = np.linspace(-1, 2, 61)
nodes = np.array([-0.75, -0.25, 0.25, 0.75, 1.25])


def eccentricity(curve):
    """Of the ellipse with the second moments of the contact area."""
    fourth = curve.contour**4
    along, across = ((fourth * part**2).sum("phi") for part in (np.cos(curve.phi), np.sin(curve.phi)))
    return np.sqrt(1 - across / along)


figure, axes = plt.subplots(figsize=(5.5, 3.8), layout="constrained")
for bonded, colour in ((False, "C0"), (True, "C1")):
    layer = fp.Medium([fp.Layer(0.75, 0.5, 1.0, bonded=bonded)], base=fp.RigidBase())
    label = "bonded, incompressible" if bonded else "unbonded"
    for name, style in (("first-order", "-"), ("second-order", "--")):
        curve = fp.indent(layer, tip, radius=10.0**-log_thickness, method=name)
        axes.plot(log_thickness, eccentricity(curve) - e_g, style, color=colour, label=f"{label}, {name}")
    depths = fp.indent(layer, tip, radius=10.0**-nodes, method="second-order").depth.values
    exact = fp.indent(layer, tip, depth=depths, method="bem", grid=200)
    axes.plot(-np.log10(exact.radius), eccentricity(exact) - e_g, "o", color=colour, mfc="w", ms=5)
axes.axhline(0, color="0.7", lw=0.8, zorder=0)
axes.invert_xaxis()
axes.set_xlabel(r"$\log_{10}(h/a_0)$")
axes.set_ylabel("$e - e_g$")
axes.set_title("markers: boundary elements")
axes.legend(frameon=False)
