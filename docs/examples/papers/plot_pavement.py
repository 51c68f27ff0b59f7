r"""
Three-layer pavement under two wheels
=====================================

Layered elastic analysis is how roads have been designed since Burmister 1945: tension at the lower face of the asphalt
governs cracking, compression on the subgrade rutting. Two wheels of a dual tyre, 0.7 MPa each, add up.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

ROAD = fp.Medium([fp.Layer(3e9, 0.35, 0.15), fp.Layer(0.3e9, 0.40, 0.30)], fp.HalfSpace(50e6, 0.45))
WHEELS = [fp.DiscLoad(pressure=0.7e6, radius=0.1, center=(0.0, y)) for y in (-0.17, 0.17)]

# %%
# Section through both wheels.

_, axes = plt.subplots(figsize=(6, 3.8), layout="constrained")
y, z = np.meshgrid(np.linspace(-0.6, 0.6, 161), np.linspace(0, 0.8, 121))
fp.plot_fields(fp.fields(ROAD, WHEELS, 0.0, y, z), axes, medium=ROAD)

# %%
# The two quantities of design: stress along the road at the lower face of the asphalt, and vertical stress on the subgrade.

_, axes = plt.subplots(figsize=(6, 3.8), layout="constrained")
across = np.linspace(-0.6, 0.6, 241)
asphalt = fp.fields(ROAD, WHEELS, 0.0, across, 0.15, side="above").stress.sel(component="xx")
subgrade = fp.fields(ROAD, WHEELS, 0.0, across, 0.45).stress.sel(component="zz")
axes.plot(across, asphalt / 1e6, color="#c1121f", label="asphalt, lower face, along the road")
axes.plot(across, 10 * subgrade / 1e6, color="#1f4e79", label="subgrade, vertical, ten times")
axes.axhline(0, color="#8c8c8c", linewidth=0.6)
axes.set_xlabel("$y$ (m)")
axes.set_ylabel("stress (MPa)")
axes.set_ylim(-0.55, 0.8)
axes.legend(loc="lower center", frameon=False)
plt.show()
