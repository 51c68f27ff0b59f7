"""
Pull-off from a thin layer
==========================

A half-space lets go of a sphere at 1.5 pi w R (Johnson, Kendall and Roberts 1971). A thin layer holds it better: 2 pi w R where
it is compressible or slides, 3 pi w R where it is bonded and incompressible (Yang 2002).
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

bead = fp.Paraboloid(radius=1.0)
modulus = np.geomspace(0.5, 3e9, 13)  # of the layer; soft layers make wide contacts


def force(bonded, poisson, thickness=0.02):
    """Pull-off force over pi w R, and the contact radius there, for w = 1."""
    found = []
    for young in modulus:
        layer = fp.Medium([fp.Layer(young, poisson, thickness, bonded=bonded)], base=fp.RigidBase())
        state = fp.pull_off(layer, bead, work_of_adhesion=1.0)
        found.append((state.radius / thickness, -state.force / np.pi))
    return np.array(found).T


figure, axes = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
for label, case in {"sliding": (False, 0.5), "bonded, nu = 0.3": (True, 0.3), "bonded, nu = 0.5": (True, 0.5)}.items():
    a, pulled = force(*case)
    axes.semilogx(a, pulled, label=label)
for limit in (1.5, 2.0, 3.0):
    axes.axhline(limit, color="0.75", lw=0.8, zorder=0)
axes.set_xlabel("contact radius at pull-off / layer thickness")
axes.set_ylabel(r"pull-off force / $\pi w R$")
axes.legend(frameon=False)
