r"""
Contact with adhesion: Johnson, Kendall and Roberts 1971, and thin layers
=========================================================================

Left: contact radius over force of a sphere that sticks to a half-space, the relation of K. L. Johnson, K. Kendall and
A. D. Roberts (Proc. R. Soc. London A 324, 301), :math:`a^3 = \frac{3R}{4E^*}\left(F + 3\pi wR + \sqrt{6\pi wRF + (3\pi
wR)^2}\right)`. Lines are computed, markers are the relation; the dashed part is unstable under a prescribed force.

Right: the force at which the sphere lets go. A half-space holds it by :math:`\frac32\pi wR`, whatever its modulus. A
thin layer holds it better: by :math:`2\pi wR` where it slides or is compressible, by :math:`3\pi wR` where it is bonded
and incompressible.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

bead = fp.Paraboloid(radius=1.0)
figure, (branch, forces) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")

# E* = 1, w = 1/pi and R = 1: forces are over pi w R
space, work = fp.HalfSpace(young=0.75, poisson=0.5), 1 / np.pi
lost = fp.pull_off(space, bead, work_of_adhesion=work)
radius = np.linspace(0.4, 2.35, 120)
contact = fp.indent(space, bead, radius=radius, work_of_adhesion=work)
stable = radius >= lost.radius
branch.plot(contact.force[stable], radius[stable], "C0", label="with adhesion")
branch.plot(contact.force[~stable], radius[~stable], "C0--")
force = np.linspace(-1.5, 5.5, 15)
branch.plot(
    force, np.cbrt(0.75 * (force + 3 + np.sqrt(6 * force + 9))), "o", color="C0", mfc="w", ms=5, label="JKR 1971"
)
pressed = np.linspace(0, 6, 60)
branch.plot(pressed, fp.indent(space, bead, force=pressed).radius, color="0.6", label="without adhesion (Hertz)")
branch.axvline(-1.5, color="0.8", lw=0.8, zorder=0)
branch.set_xlim(-1.8, 6)
branch.set_ylim(0, 2.4)
branch.set_xlabel(r"$F/\pi w R$")
branch.set_ylabel("contact radius")
branch.legend(frameon=False, loc="lower right")

# the stickier the sphere, the wider the contact when it is lost
cases = {"sliding": (False, 0.5), r"bonded, $\nu = 0.3$": (True, 0.3), r"bonded, $\nu = 0.5$": (True, 0.5)}
for label, (bonded, poisson) in cases.items():
    layer = fp.Medium([fp.Layer(1.0, poisson, 0.02, bonded=bonded)], base=fp.RigidBase())
    found = []
    for work in np.geomspace(3e-10, 2, 15):
        state = fp.pull_off(layer, bead, work_of_adhesion=work)
        found.append((state.radius / 0.02, -state.force / (np.pi * work)))
    forces.semilogx(*np.transpose(found), "o-", ms=3, label=label)
for limit in (1.5, 2.0, 3.0):
    forces.axhline(limit, color="0.8", lw=0.8, zorder=0)
forces.set_xlabel("contact radius at pull-off / layer thickness")
forces.set_ylabel(r"pull-off force / $\pi w R$")
forces.legend(frameon=False)
