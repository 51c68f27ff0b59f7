r"""
What a nanoindentation test on a film really measures
=====================================================

By Bückle's rule of 1961 the substrate is not felt at depths up to a tenth of the film's thickness. The depth sensitivity
:math:`\partial \ln F/\partial \ln E(z)` shows from which depth a force comes.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

TIP, THICKNESS = fp.SpheroCone(np.radians(19.7), 100e-9), 1e-6  # a cone with the area of a Berkovich tip, rounded
BODIES = {
    "film 10 times softer": fp.Medium([fp.Layer(10e9, 0.3, THICKNESS)], fp.HalfSpace(100e9, 0.25)),
    "film 5 times stiffer": fp.Medium([fp.Layer(500e9, 0.25, THICKNESS)], fp.HalfSpace(100e9, 0.25)),
}

# %%
# At an indentation depth of a tenth of the thickness, with the share of film and substrate.

_, panels = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
for axes, (name, body) in zip(panels, BODIES.items(), strict=True):
    found = fp.sensitivity(body, TIP, depth=THICKNESS / 10)
    fp.plot_sensitivity(found, axes)
    axes.set_title(f"{name}, $d = h/10$")
    print(f"{name}: {float(found.force.sel(parameter='base.young')):.3f} of the force from the substrate")

# %%
# The substrate's share over the depth: far above 1 % at a tenth of the thickness where the film is stiffer.

_, axes = plt.subplots(figsize=(5, 4), layout="constrained")
depth = THICKNESS * np.geomspace(0.005, 0.5, 16)
for (name, body), colour in zip(BODIES.items(), ("#1f4e79", "#c1121f"), strict=True):
    share = fp.sensitivity(body, TIP, depth=depth).force.sel(parameter="base.young")
    axes.semilogx(depth / THICKNESS, 100 * share, color=colour, label=name)
axes.axvline(0.1, color="#8c8c8c", linewidth=0.9)
axes.set_xlabel("depth over thickness")
axes.set_ylabel("share of the force from the substrate (%)")
axes.legend(frameon=False)
plt.show()
