"""
Which modulus does a tip feel on an anisotropic body?
=====================================================

Columnar films, bone, wood and graphite are stiffer along one direction than across it. A tip that is pressed in along that
direction feels all five constants at once: not the modulus along z, nor that in the plane.

Constants: graphite, Blakslee et al., J. Appl. Phys. 41 (1970) 3373; aluminium nitride, McNeil et al., J. Am. Ceram. Soc. 76
(1993) 1132; bone of the human tibia (mean of the two directions across), Hoffmeister et al., Med. Biol. Eng. Comput. 38 (2000)
333; Sitka spruce, ratios of the Wood Handbook (2010), tables 5-1 to 5-3, radial and tangential values averaged.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

Body = fp.TransverselyIsotropicHalfSpace
ALONG = 10.9e9  # of spruce, along the grain
BODIES = {
    "graphite": Body.from_stiffnesses(1060e9, 180e9, 15e9, 36.5e9, 4.5e9),
    "aluminium nitride": Body.from_stiffnesses(410e9, 148.5e9, 98.9e9, 388.5e9, 124.6e9),
    "bone": Body.from_stiffnesses(19.8e9, 11.7e9, 12.5e9, 30.9e9, 5.45e9),
    "spruce": Body(0.06 * ALONG, ALONG, 0.34, 0.42, 0.0625 * ALONG),
}

# %%
# Indentation modulus (of Delafargue and Ulm) beside the plane-strain moduli of isotropic bodies as stiff as this one along z, and
# as stiff as it in the plane. On graphite it is two thirds of the one and a fortieth of the other, on spruce a third and six
# times.
figure, ax = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
for place, body in enumerate(BODIES.values()):
    felt = body.surface_modulus
    guesses = (
        body.young_axial / (1 - body.poisson_axial**2),
        body.young_in_plane / (1 - body.poisson_in_plane**2),
    )
    for guess, colour, name in zip(
        guesses, ("C1", "C2"), ("isotropic, as along z", "isotropic, as in the plane"), strict=True
    ):
        ax.plot(place, guess / 1e9, "o", color=colour, label=None if place else name)
    ax.plot(place, felt / 1e9, "D", color="C0", label=None if place else "felt by a tip along z")
ax.set_yscale("log")
ax.set_xticks(range(len(BODIES)), BODIES)
ax.set_ylabel("plane-strain modulus (GPa)")
ax.legend()
plt.show()

# %%
# Films of 1 um on silicon, of graphite and of aluminium nitride: the modulus that a half-space formula gives, over the contact
# radius of a sphere of 5 um, beside isotropic films with the same indentation modulus. For the nitride these serve as well; on
# graphite, which strains decay slowly in, more of the silicon is felt.
silicon = fp.HalfSpace(young=160e9, poisson=0.22)
depth = np.geomspace(1e-9, 300e-9, 25)
figure, ax = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
for colour, name in (("C0", "graphite"), ("C1", "aluminium nitride")):
    body = BODIES[name]
    columns = fp.TransverselyIsotropicLayer.from_stiffnesses(*body.stiffnesses, thickness=1e-6)
    alike = fp.Layer(young=body.surface_modulus * (1 - 0.25**2), poisson=0.25, thickness=1e-6)
    for film, line, kind in ((columns, "-", ""), (alike, "--", ", isotropic")):
        curve = fp.indent(fp.Medium([film], base=silicon), fp.Sphere(5e-6), depth=depth)
        # on a half-space of modulus E*, the stiffness is 2 E* times the contact radius
        ax.loglog(curve.radius * 1e6, curve.stiffness / (2e9 * curve.radius), line, color=colour, label=name + kind)
ax.set_xlabel("contact radius (µm)")
ax.set_ylabel("apparent plane-strain modulus (GPa)")
ax.legend()
plt.show()
