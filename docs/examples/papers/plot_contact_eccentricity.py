r"""
Contact eccentricity on thin layers: Forsbach and Willert 2023, figures 2 to 5
==============================================================================

An elliptic paraboloid makes an elliptic contact, but not one of its own eccentricity :math:`e_g`. On a half-space the
contact is slenderer than the level lines of the tip. On thin unbonded layers it approaches them, on thin bonded
incompressible layers it becomes rounder.

The maps are the paper's figures 3 and 5: :math:`e - e_g` by the first-order method over :math:`e_g` and the layer's
thickness over the mean contact radius. On the right a cut at :math:`e_g = 0.6`, with boundary elements as in its
figures 2 and 4: the half-space's value holds until about h = 10 a0, much longer than first order has it, and on an
unbonded layer e is never below :math:`e_g`. Second order follows them. ``flatpunch paper`` makes all four maps,
boundary elements included.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

log_thickness = np.linspace(2, -1, 46)


def layer(bonded):
    """Layer of thickness 1 and E* = 1 on a rigid base."""
    return fp.Medium([fp.Layer(0.75, 0.5, 1.0, bonded=bonded)], base=fp.RigidBase())


def eccentricity(bonded, e_g, method):
    """Contact eccentricity for all thicknesses, from the half-axes of the contact."""
    tip = fp.EllipticParaboloid(A=1 - e_g**2, B=1.0)
    curve = fp.indent(layer(bonded), tip, radius=10.0**-log_thickness, method=method, angles=4)
    return np.sqrt(1 - (curve.contour[:, 1] / curve.contour[:, 0]) ** 2)


figure, panels = plt.subplots(1, 3, figsize=(12, 3.9), layout="constrained")
indenter = np.linspace(0.02, 0.95, 32)
levels = np.arange(-0.08, 0.081, 0.01)
for axes, bonded in zip(panels, (False, True), strict=False):
    values = [eccentricity(bonded, e_g, "first-order") - e_g for e_g in indenter]
    filled = axes.contourf(log_thickness, indenter, values, levels, cmap="RdBu_r", alpha=0.75, extend="both")
    lines = axes.contour(log_thickness, indenter, values, levels[::2], colors="k", linewidths=0.8, linestyles="solid")
    axes.clabel(lines, fmt=lambda value: f"{value:.2f}".replace("-0.00", "0"), fontsize=7)
    axes.set_title(f"$e - e_g$, {'bonded incompressible' if bonded else 'unbonded'}, first order", fontsize=10)
    axes.set_ylabel("$e_g$")
figure.colorbar(filled, ax=panels[:2], ticks=levels[::4])

cut, chosen = panels[2], 0.6
nodes = 10.0 ** -np.array([1.25, 0.75, 0.25, -0.25, -0.75])
for bonded, colour in ((False, "C0"), (True, "C1")):
    for name, style in (("first-order", "-"), ("second-order", "--")):
        label = f"{'bonded' if bonded else 'unbonded'}, {name.replace('-', ' ')}"
        cut.plot(log_thickness, eccentricity(bonded, chosen, name) - chosen, style, color=colour, label=label)
    tip = fp.EllipticParaboloid(A=1 - chosen**2, B=1.0)
    depth = fp.indent(layer(bonded), tip, radius=nodes, method="second-order", angles=4).depth.values
    exact = fp.indent(layer(bonded), tip, depth=depth, method=fp.BoundaryElements(grid=200), angles=360)
    measured = np.sqrt(1 - (exact.contour[:, 90] / exact.contour[:, 0]) ** 2)
    cut.plot(-np.log10(exact.radius), measured - chosen, "o", color=colour, mfc="w", ms=5)
cut.axhline(0, color="0.8", lw=0.8, zorder=0)
cut.set_title(f"$e - e_g$ at $e_g = {chosen}$; markers: boundary elements", fontsize=10)
cut.legend(frameon=False, fontsize=8)
for axes in panels:
    axes.set_xlim(2, -1)
    axes.set_xlabel(r"$\log_{10}(h/a_0)$")
