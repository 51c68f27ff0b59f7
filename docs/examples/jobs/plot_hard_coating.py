r"""
A coating under a sphere: stress and first failure
==================================================

Grading the modulus from a coating to its base takes the jump out of the stress along the interface, the reason for which
Suresh 2001 (Science 292, 2447) and many since recommend it. A sphere of 50 um presses with 20 mN on 2 um of a coating of
500 GPa on steel; the interlayer replaces the lower half of the coating.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

STEEL, TIP, FORCE = fp.HalfSpace(210e9, 0.3), fp.Sphere(50e-6), 20e-3
PLAIN = fp.Medium([fp.Layer(500e9, 0.25, 2e-6)], STEEL)
GRADED = fp.Medium(
    [fp.Layer(500e9, 0.25, 1e-6), fp.GradedLayer(fp.LinearModulus(500e9, 210e9, 1e-6), 0.25, 1e-6)], STEEL
)

# %%
# Von Mises stress in the section y = 0, interfaces drawn.

_, panels = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
x, z = np.meshgrid(np.linspace(-5e-6, 5e-6, 121), np.linspace(0, 4e-6, 91))
for axes, medium, name in zip(panels, (PLAIN, GRADED), ("plain", "graded interlayer"), strict=True):
    fp.plot_fields(fp.fields(medium, TIP, x, 0.0, z, force=FORCE), axes, medium=medium)
    axes.set_title(name)

# %%
# Tension along the surface bends the coating below the axis: radial cracks start at the lower face of the stiff part.

_, axes = plt.subplots(figsize=(5, 4), layout="constrained")
for medium, colour, name in ((PLAIN, "#c1121f", "plain"), (GRADED, "#1f4e79", "graded interlayer")):
    for low, high in ((1e-9, 0.9999e-6), (1.0001e-6, 1.9999e-6), (2.0001e-6, 4e-6)):
        depth = np.linspace(low, high, 60)
        along = fp.fields(medium, TIP, 0.0, 0.0, depth, force=FORCE).stress.sel(component="xx")
        axes.plot(along / 1e9, depth * 1e6, color=colour, label=name if low < 1e-8 else None)
axes.invert_yaxis()
axes.set_xlabel(r"$\sigma_{xx}$ on the axis (GPa)")
axes.set_ylabel("$z$ (µm)")
axes.legend(frameon=False)

# %%
# The load at which the first layer fails, with assumed strengths: the steel yields below both coatings, or the coating cracks.

COATING, YIELDS = fp.Strength(tensile=2.5e9), fp.Strength(yield_stress=1.5e9)
for medium, name in ((PLAIN, "plain"), (GRADED, "graded interlayer")):
    strengths = [*[COATING] * len(medium.layers), YIELDS]
    found = fp.critical_load(medium, TIP, strengths=strengths)
    part = "the steel" if found.layer == len(medium.layers) else f"layer {found.layer + 1}"
    print(
        f"{name}: {found.kind} at {found.force * 1e3:.1f} mN in {part}, {found.place[2] * 1e6:.1f} µm below the surface"
    )
plt.show()
