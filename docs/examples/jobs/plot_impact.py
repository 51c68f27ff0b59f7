"""
A sphere that hits a coated plate
=================================

How long does a steel sphere touch a coated plate on which it falls, and how large is its force? As long as the impact is slow
against the waves in both bodies, the force is that of the static contact of the same depth (Hertz 1882), and the energy of
motion is what the contact takes up: v^2 = V^2 - 2 W(d)/m.
"""

import matplotlib.pyplot as plt
import numpy as np
import scipy.optimize
import scipy.special

import flatpunch as fp

RADIUS, SPEED = 2e-3, 0.5
MASS = 7850 * 4 / 3 * np.pi * RADIUS**3
STEEL = fp.HalfSpace(young=210e9, poisson=0.3)
PLATE = fp.HalfSpace(young=70e9, poisson=0.33)
TIP = fp.Paraboloid(RADIUS)

points, weights = np.polynomial.legendre.leggauss(40)
share, weights = (1 + points) / 2, weights / 2


def work(target, depth):
    """Energy of the contact up to some depths: Gauss points in the root of the depth, of which the force is smooth."""
    pair = fp.TwoBodies(upper=STEEL, lower=target)
    force = fp.indent(pair, TIP, depth=np.outer(depth, share**2).ravel(), angles=1).force.values
    return force.reshape(-1, share.size) @ (2 * share * weights) * depth


def impact(target):
    """Times and depths until the sphere is at rest.

    With d = D sin^2 u the time, int dd/v, has no root at the deepest point D.
    """
    energy = MASS * SPEED**2 / 2
    deepest = scipy.optimize.brentq(
        lambda depth: work(target, np.array([depth]))[0] / energy - 1, 1e-7, 1e-3, xtol=1e-18
    )
    ends = np.linspace(0, np.pi / 2, 41)
    u = ends[:-1, None] + np.diff(ends)[:, None] * share
    speed = SPEED * np.sqrt(1 - work(target, (deepest * np.sin(u) ** 2).ravel()).reshape(u.shape) / energy)
    steps = np.diff(ends) * ((deepest * np.sin(2 * u) / speed) @ weights)
    return np.append(0.0, np.cumsum(steps)), deepest * np.sin(ends) ** 2


# %%
# Without a coating this is Hertz's closed form, 2.94 D/V.
time, depth = impact(PLATE)
rho = scipy.special.beta(0.4, 0.5) * 0.8 * depth[-1] / SPEED
print(f"time of contact {2e6 * time[-1]:.4f} us; by Hertz {1e6 * rho:.4f} us")

# %%
# Softer coatings make the impact longer and its force smaller.
figure, axes = plt.subplots(figsize=(5.6, 3.8), layout="constrained")
for thickness in (0.0, 20e-6, 100e-6):
    layers = [fp.Layer(young=3e9, poisson=0.4, thickness=thickness)] if thickness else []
    target = fp.Medium(layers, base=PLATE)
    time, depth = impact(target)
    force = fp.indent(fp.TwoBodies(upper=STEEL, lower=target), TIP, depth=depth, angles=1).force.values
    # back along the same way
    label = f"{thickness * 1e6:.0f} µm of polymer" if thickness else "aluminium"
    axes.plot(1e6 * np.append(time, 2 * time[-1] - time[::-1]), np.append(force, force[::-1]), label=label)
axes.set_xlabel("time (µs)")
axes.set_ylabel("force (N)")
axes.legend()
plt.show()
