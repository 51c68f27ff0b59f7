r"""
Pressure under a flat punch: power-law media and thin layers
============================================================

On a half-space with :math:`E \propto z^k` the pressure under a flat punch is :math:`(1-\rho^2)^{(k-1)/2}` (A. E.
Giannakopoulos and S. Suresh, Int. J. Solids Struct. 34, 2357 (1997)): singular at the edge below k = 1, uniform
at k = 1. Thin layers on a rigid base become such media, as the paper of Forsbach and Willert states: sliding ones k = 1,
bonded incompressible ones k = 3. Their singularity does not vanish; it retreats into an ever narrower rim.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

rho = np.sin(np.linspace(0, np.pi / 2, 400)[:-1])
figure, (graded, layers) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained", sharey=True)


def shown(axes, medium, radius, label, colour):
    """Pressure over its mean."""
    punch = fp.flat_punch(medium, radius)
    mean = punch.stiffness / (np.pi * radius**2)
    axes.plot(rho, punch.pressure(rho * radius) / mean, color=colour, label=label)


exponents = (-0.4, 0.0, 0.4, 0.8, 1.0)
for k, colour in zip(exponents, plt.cm.viridis(np.linspace(0, 0.85, 5)), strict=True):
    shown(graded, fp.PowerLawHalfSpace(modulus=1.0, depth=1.0, exponent=k, poisson=0.5), 1.0, f"k = {k:g}", colour)
for bonded, map_, k in ((False, plt.cm.Blues, 1), (True, plt.cm.Oranges, 3)):
    layer = fp.Medium([fp.Layer(0.75, 0.5, 1.0, bonded=bonded)], base=fp.RigidBase())
    for ratio, shade in ((1, 0.45), (5, 0.65), (30, 0.95)):
        shown(layers, layer, ratio, f"{'bonded' if bonded else 'sliding'}, a/h = {ratio}", map_(shade))
    layers.plot(rho[::25], (k + 1) / 2 * (1 - rho[::25] ** 2) ** ((k - 1) / 2), "k.", ms=4, label=f"k = {k}")
graded.set_ylabel("pressure / mean pressure")
graded.set_title(r"half-spaces $E \propto z^k$", fontsize=10)
layers.set_title("incompressible layers on a rigid base", fontsize=10)
for axes in (graded, layers):
    axes.set_ylim(0, 3)
    axes.set_xlabel("r/a")
    axes.legend(frameon=False, fontsize=8, loc="upper left", ncols=2)
