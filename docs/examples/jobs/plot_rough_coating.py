r"""
A rough surface on a carbon film on steel
=========================================

How much of a rough, stiff counter-surface really touches a coating, and does the coating change it? A random surface of 5 um side
with rms slope 0.08 presses on 100 nm of hard carbon (250 GPa) on steel and on a polymer (3 GPa), on 100 nm of polymer on steel,
and on bare steel.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

ROUGH = fp.self_affine(128, 40e-9, rms_slope=0.08, roll_off=2e-6, cut_off=320e-9, seed=1)
STEEL = fp.HalfSpace(210e9, 0.3)
BODIES = {
    "bare steel": STEEL,
    "carbon on steel": fp.Medium([fp.Layer(250e9, 0.22, 100e-9)], base=STEEL),
    "polymer on steel": fp.Medium([fp.Layer(3e9, 0.4, 100e-9)], base=STEEL),
    "carbon on polymer": fp.Medium([fp.Layer(250e9, 0.22, 100e-9)], base=fp.HalfSpace(3e9, 0.4)),
}

# %%
# The contact area over the mean pressure over the modulus of the surface times the rms slope: all half-spaces fall onto one
# curve. Carbon on steel is close to it. Waves longer than the film is thick feel the steel under the polymer, and bend the
# carbon into the polymer, which gives way: more of it touches at small loads than under a massive body of carbon.

_, axes = plt.subplots(figsize=(5, 4), layout="constrained")
for (name, body), dashes in zip(BODIES.items(), ("k--", "-o", "-.s", ":^"), strict=True):
    unit = body.surface_modulus * ROUGH.rms_slope
    contact = fp.rough_contact(body, ROUGH, pressure=unit * np.geomspace(1e-3, 1, 8))
    axes.plot(contact.mean_pressure / unit, 100 * contact.area_fraction_corrected, dashes, label=name, markersize=4)
axes.loglog()
axes.set_xlabel(r"mean pressure$\,/\,(E^* \times$ rms slope$)$")
axes.set_ylabel("share of the area in contact (%)")
axes.legend(frameon=False)

# %%
# Beside the theories: Greenwood and Williamson's summits are good at small loads, Persson's theory towards full contact.

body = BODIES["carbon on steel"]
contact = fp.rough_contact(body, ROUGH, pressure=np.geomspace(20e6, 40e9, 9))
fp.plot_rough(contact, theories=fp.rough_theories(contact, body, ROUGH))

# %%
# The stress inside the film under the surface, which here ends at its border: von Mises stress in a section at 1 GPa.

ends = fp.Topography(ROUGH.heights, ROUGH.spacing, periodic=False)
step = fp.rough_contact(body, ends, pressure=1e9, fields=True)
x, z = np.meshgrid(np.linspace(-2e-6, 2e-6, 201), np.linspace(10e-9, 0.6e-6, 40))
inside = fp.fields(body, fp.PatchLoad(step.pressure.values[0], ends.spacing), x, 0.0, z)
_, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
drawn = axes.pcolormesh(x * 1e6, z * 1e6, inside.von_mises.values / 1e9, shading="gouraud", cmap="magma")
axes.axhline(0.1, color="white", linewidth=0.8)
axes.invert_yaxis()
axes.set_xlabel("$x$ (µm)")
axes.set_ylabel("$z$ (µm)")
plt.colorbar(drawn, ax=axes, label="von Mises stress (GPa)")
plt.show()
