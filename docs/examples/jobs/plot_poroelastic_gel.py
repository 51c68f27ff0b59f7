"""
Water that leaves a gel
=======================

A bead is pressed into a swollen gel and held: the force falls while water flows out of the way. At once the gel is
incompressible, at the end the water carries nothing and the network alone is left, compressible. Both ends are elastic
contacts, on a layer too; the course between them is known for half-spaces (Hu, Zhao, Vlassak and Suo, Applied Physics Letters
96, 2010, 121904).
"""

import matplotlib.pyplot as plt
import numpy as np
import scipy.optimize

import flatpunch as fp

BEAD, DEPTH = fp.Sphere(radius=2e-3), 50e-6
SHEAR, POISSON, DIFFUSIVITY = 12e3, 0.28, 2e-10


def ends(shear, poisson):
    """Forces at the beginning and at the end."""
    bodies = [fp.HalfSpace(young=2 * shear * (1 + nu), poisson=nu) for nu in (0.5, poisson)]
    return [float(fp.indent(body, BEAD, depth=DEPTH).force[0]) for body in bodies]


def course(time, shear, poisson, diffusivity):
    """Forces over the time; the radius of the contact stays, as the depth does."""
    radius = float(fp.indent(fp.HalfSpace(1.0, 0.5), BEAD, depth=DEPTH).radius[0])
    scaled = diffusivity * time / radius**2
    left = 0.491 * np.exp(-0.908 * np.sqrt(scaled)) + 0.509 * np.exp(-1.679 * scaled)
    first, last = ends(shear, poisson)
    return last + (first - last) * left


# %%
# A test of an hour with 0.5 % of noise, and what a fit finds: the beginning gives the shear modulus, the end Poisson's ratio of
# the network, and the time between them the diffusivity of the water.
time = np.geomspace(0.5, 3600, 120)
measured = course(time, SHEAR, POISSON, DIFFUSIVITY) * (1 + 0.005 * np.random.default_rng(1).standard_normal(time.size))
found, covariance = scipy.optimize.curve_fit(
    lambda t, *logs: course(t, *np.exp(logs)), time, measured, np.log([1e4, 0.2, 1e-10]), sigma=0.005 * measured
)
for name, unit, value, share in zip(
    ("shear modulus", "Poisson's ratio", "diffusivity"),
    ("Pa", "", "m²/s"),
    np.exp(found),
    np.sqrt(np.diag(covariance)),
    strict=True,
):
    print(f"{name} {value:.4g} {unit}, standard deviation {100 * share:.1f} %")

figure, ax = plt.subplots(figsize=(5.6, 3.8), layout="constrained")
ax.plot(time, 1e3 * measured, ".", color="grey", label="measured")
ax.plot(time, 1e3 * course(time, *np.exp(found)), label="Hu 2010")
for force, name in zip(ends(SHEAR, POISSON), ("incompressible", "drained"), strict=True):
    ax.axhline(1e3 * force, color="black", linewidth=0.8, linestyle="--")
    ax.annotate(name, (time[0], 1e3 * force), xytext=(0, 3), textcoords="offset points")
ax.set_xscale("log")
ax.set_xlabel("time (s)")
ax.set_ylabel("force (mN)")
ax.legend(loc="center left")
plt.show()

# %%
# Cones and flat ends have courses of their own: sphere and cone after Hu 2010, and a flat end that seals the gel below it after
# Lai and Hu 2017. Time is over a^2/D, a the radius of the contact. All pass from the incompressible to the drained force; the
# flat end is the first half way and the last at the end.
SPAN = np.geomspace(1e-4, 1e2, 200)
LEFT = {
    "sphere": 0.491 * np.exp(-0.908 * np.sqrt(SPAN)) + 0.509 * np.exp(-1.679 * SPAN),
    "cone": 0.493 * np.exp(-0.822 * np.sqrt(SPAN)) + 0.507 * np.exp(-1.348 * SPAN),
    "flat end": 0.242 * np.exp(-3.13 * SPAN)
    + 0.536 * np.exp(-1.71 * np.sqrt(SPAN))
    - 0.043 * np.exp(-12.8 * np.cbrt(SPAN))
    + 0.266 * np.exp(-0.892 * SPAN**0.25),
}
TIPS = {"sphere": BEAD, "cone": fp.Cone(inclination=np.radians(20)), "flat end": fp.Cylinder(radius=0.5e-3)}
figure, ax = plt.subplots(figsize=(5.6, 3.8), layout="constrained")
for name, left in LEFT.items():
    first, last = (
        float(fp.indent(fp.HalfSpace(young=2 * SHEAR * (1 + nu), poisson=nu), TIPS[name], depth=DEPTH).force[0])
        for nu in (0.5, POISSON)
    )
    print(
        f"{name}: {1e3 * first:.2f} to {1e3 * last:.2f} mN, half of the way at t = {np.interp(-0.5, -left, SPAN):.2f} a^2/D"
    )
    ax.semilogx(SPAN, last + (first - last) * left, label=name)
ax.set_xlabel("time over a^2/D")
ax.set_ylabel("force (N)")
ax.legend()
plt.show()

# %%
# On a layer that is bonded to glass only the ends are known. Their ratio is 2 (1 - nu) on a half-space, and grows where the
# layer is thin, as an incompressible one can only flow aside: the same network relaxes much further.
for thickness in (10e-3, 1e-3, 0.3e-3):
    forces = []
    for nu in (0.5, POISSON):
        layer = fp.Layer(young=2 * SHEAR * (1 + nu), poisson=nu, thickness=thickness)
        forces.append(float(fp.indent(fp.Medium([layer], base=fp.RigidBase()), BEAD, depth=DEPTH).force[0]))
    print(
        f"{thickness * 1e3:4.1f} mm: {1e3 * forces[0]:.2f} to {1e3 * forces[1]:.2f} mN, ratio {forces[0] / forces[1]:.2f}"
    )
