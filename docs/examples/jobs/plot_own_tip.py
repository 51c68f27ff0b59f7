r"""
A tip that was measured
=======================

A worn four-sided tip as a height map, as a scan over sharp spikes or an electron microscope gives it: blunt, slightly
tilted, with noise below a nanometre. ``fp.HeightMap`` finds the apex; ``fp.read_height_map`` reads the same from the file of
a microscope.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

x = np.linspace(-400e-9, 400e-9, 121)
X, Y = np.meshgrid(x, x)
pyramid = np.maximum(np.abs(X), np.abs(Y)) * np.tan(np.radians(55))
blunt = np.sqrt(pyramid**2 + (40e-9) ** 2) - 40e-9  # wear
noise = 0.3e-9 * np.random.default_rng(3).normal(size=X.shape)
tip = fp.HeightMap(x, x, blunt + np.tan(np.radians(4)) * X + noise, smoothing=8e-9, reach="usable")
print(
    f"apex at {tip.centre[0] * 1e9:.0f} nm, {tip.centre[1] * 1e9:.0f} nm; used up to {tip.reach * 1e9:.0f} nm from it"
)

# %%
# A height map has no closed form: by default ``fp.indent`` corrects the round contact by boundary elements ("refined").

GEL = fp.Medium([fp.Layer(young=20e3, poisson=0.5, thickness=500e-9)], base=fp.RigidBase())
depth = np.linspace(5e-9, 150e-9, 12)
worn = fp.indent(GEL, tip, depth=depth)
sharp = fp.indent(GEL, fp.Pyramid(sides=4, inclination=np.radians(55)), depth=depth)
print(
    f"method {worn.attrs['method']}; force of the sharp pyramid over that of the worn tip at 50 nm: "
    f"{np.interp(50e-9, depth, sharp.force / worn.force):.2f}"
)

# %%
# Level lines of the tip, force, and outlines of the contact.

figure, (shape, force, outline) = plt.subplots(1, 3, figsize=(13, 4), layout="constrained")
fp.plot_tip(tip, shape)
force.plot(depth * 1e9, worn.force * 1e9, label="worn tip")
force.plot(depth * 1e9, sharp.force * 1e9, "--", color="0.4", label="sharp pyramid")
force.set_xlabel("indentation depth (nm)")
force.set_ylabel("normal force (nN)")
force.legend(frameon=False)
fp.plot_outline(worn, outline)
plt.show()
