r"""
Fretting of a coating
=====================

A rigid sphere is pressed on a hard coating and moved to and fro along it by a few hundred nanometres. It sticks in the middle and
slips in a ring at the rim until it slides as a whole. Half-space formulas (Cattaneo, Mindlin) need one elastic body; here the
coating and the softer base share the deformation, and share it differently under forces along the surface.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

base = fp.HalfSpace(young=110e9, poisson=0.33)
coated = fp.Medium([fp.Layer(young=500e9, poisson=0.25, thickness=3e-6)], base=base)
sphere = fp.Sphere(radius=5e-3)

figure, (first, second) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained", sharex=True, sharey=True)
for body, name, axes in ((coated, "3 µm of coating on titanium", first), (base, "titanium alone", second)):
    pulled = fp.partial_slip(body, sphere, friction=0.4, force=5.0, displacement=np.linspace(0, 350e-9, 60))
    fp.plot_curve(pulled, axes)
    axes.set_title(f"{name}\n{axes.get_title()}", fontsize=9)
    print(f"{name}: {pulled.lateral_stiffness.values[0] / 1e6:.1f} N/µm while it sticks,")
    print(f"  errors of forces up to {pulled.error.values.max():.1%}")
