r"""
Area function or pyramid: a Berkovich tip on fused silica
=========================================================

Calibrated indenters come with an area function :math:`A(h) = C_0 h^2 + C_1 h + \dots`; it describes a round tip of the same
sections. The pyramid itself, rounded at its apex, is ``fp.Berkovich(tip_radius=...)``. On fused silica both are compared, with
the method that ``fp.indent`` chooses by itself.

The contact is elastic. Real tests on hard materials leave an imprint at most depths: only the first nanometres of the loading,
before the first plastic event, follow these curves. What is elastic in the rest of a test is the stiffness on unloading, from
which :ref:`a film's modulus <sphx_glr_gallery_jobs_plot_film_modulus.py>` is found.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

SILICA = fp.HalfSpace(young=72e9, poisson=0.17)
RADIUS = 100e-9
pyramid = fp.Berkovich(tip_radius=RADIUS)
slope = np.sqrt(24.5 / np.pi)  # of the cone with the area of the pyramid
# a sphere of this radius at first, the cone far above: A = 24.5 h^2 + 2 pi R h
area = fp.AreaFunction([24.5, 2 * np.pi * RADIUS / 1e-9], limit=300e-9, unit=1e-9)
depth = np.linspace(1e-9, 120e-9, 40)

_, axes = plt.subplots(figsize=(5, 4), layout="constrained")
curves = {}
for name, tip, style in (("pyramid, rounded", pyramid, "-"), ("area function", area, "--")):
    curves[name] = fp.indent(SILICA, tip, depth=depth)
    axes.plot(depth * 1e9, curves[name].force * 1e3, style, label=name)
    print(f"{name}: method {curves[name].attrs['method']}, {float(curves[name].force[-1]) * 1e3:.3f} mN at 120 nm")
axes.plot(depth * 1e9, fp.indent(SILICA, fp.Sphere(RADIUS), depth=depth).force * 1e3, ":", color="0.4", label="sphere")
axes.set_xlabel("indentation depth (nm)")
axes.set_ylabel("normal force (mN)")
axes.set_ylim(0, 1.1e3 * float(curves["pyramid, rounded"].force[-1]))
axes.legend(frameon=False)

# %%
# Far above its rounding the pyramid needs some per cent more force than the round tip of its area (2.7 to 7.8 % for sharp
# pyramids); near the apex the two are rounded in different ways. Results with an area function say so in their notes.

ratio = curves["area function"].force / curves["pyramid, rounded"].force
_, axes = plt.subplots(figsize=(5, 4), layout="constrained")
axes.plot(depth * 1e9, ratio, color="0.2")
axes.axhline(1, color="0.8", lw=0.8)
axes.set_xlabel("indentation depth (nm)")
axes.set_ylabel("force, area function over pyramid")
plt.show()
