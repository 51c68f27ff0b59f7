"""
Moduli of a road from a deflection bowl
=======================================

A falling weight presses a road with 0.7 MPa on a disc of 150 mm radius, and sensors measure how far its surface sinks up to
1.8 m away. Which moduli do its layers have? The bowl is one of the AMADEUS benchmark of pavement programs (European
Commission, 2000): 161 mm of asphalt on 260 mm of gravel on the ground.
"""

import matplotlib.pyplot as plt
import numpy as np
import scipy.optimize

import flatpunch as fp

RADIUS, PRESSURE = 0.15, 0.7e6
PLACE = np.array([0, 200, 300, 450, 600, 900, 1200, 1500, 1800]) * 1e-3
SUNK = np.array([298.9, 244.2, 220.07, 175, 138, 97.3, 72.2, 57.4, 47.6]) * 1e-6


def road(moduli):
    """Asphalt and gravel on the ground."""
    asphalt, gravel, ground = moduli
    layers = [fp.Layer(asphalt, 0.35, 0.161), fp.Layer(gravel, 0.35, 0.26)]
    return fp.Medium(layers, base=fp.HalfSpace(ground, 0.35))


def bowl(moduli):
    """Deflections at the sensors."""
    wheel = fp.DiscLoad(radius=RADIUS, pressure=PRESSURE)
    return fp.fields(road(moduli), wheel, x=PLACE, y=0.0, z=0.0).displacement.sel(axis="z").values


# %%
# Least squares of the relative deviations, over the logarithms of the moduli. The standard deviations are those that the
# scatter of the nine readings leaves: the far sensors know the ground well, the gravel is known least.
found = scipy.optimize.least_squares(
    lambda logs: bowl(np.exp(logs)) / SUNK - 1, np.log([3e9, 3e8, 1e8]), diff_step=1e-5, x_scale=0.1
)
moduli = np.exp(found.x)
scatter = np.sqrt(2 * found.cost / (PLACE.size - 3))
share = scatter * np.sqrt(np.diag(np.linalg.inv(found.jac.T @ found.jac)))
for name, modulus, relative in zip(("asphalt", "gravel", "ground"), moduli, share, strict=True):
    print(f"{name}: {modulus / 1e6:.0f} MPa, standard deviation {100 * relative:.0f} %")

# %%
# Deviations of up to 2.7 % that change their sign along the bowl are no noise of the sensors: the ground is not one material
# down to infinity.
figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.4), layout="constrained")
axes[0].plot(PLACE, SUNK * 1e6, "o", label="measured")
axes[0].plot(PLACE, bowl(moduli) * 1e6, label="three layers")
axes[0].invert_yaxis()
axes[0].set_ylabel("deflection (µm)")
axes[0].legend()
axes[1].plot(PLACE, 100 * found.fun, "o-")
axes[1].axhline(0.0, color="grey", linewidth=0.8)
axes[1].set_ylabel("deviation (%)")
for ax in axes:
    ax.set_xlabel("distance from the axis (m)")
plt.show()
