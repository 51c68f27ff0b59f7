r"""
A sliding sphere: Hamilton 1983, and the same on a coating
==========================================================

G. M. Hamilton (Proc. Inst. Mech. Eng. C 197, 53) gave the stresses under a sliding sphere in closed form: friction brings
tension to the trailing edge, :math:`p_0 [(1-2\nu)/3 + (4+\nu)\pi f/8]`, and moves the first yield to the surface. On a stiff
coating the tension is far larger.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

NU, FRICTION = 0.3, 0.25
BODY = fp.HalfSpace(200e9, NU)
COATED = fp.Medium([fp.Layer(600e9, 0.25, 1e-6)], BODY)
TIP, A = fp.Paraboloid(50e-6), 3e-6

# %%
# Stress along the direction of sliding on the surface, over the peak pressure of the uncoated body.

_, axes = plt.subplots(figsize=(5, 3.8), layout="constrained")
x = np.linspace(-3, 3, 401) * A
peak = float(fp.pressure(BODY, TIP, 0, 0, radius=A))
for medium, colour, name in ((BODY, "#1f4e79", "half-space"), (COATED, "#c1121f", "coating three times stiffer")):
    found = fp.fields(medium, TIP, x, 0.0, 0.0, radius=A, friction=FRICTION)
    axes.plot(x / A, found.stress.sel(component="xx") / peak, color=colour, label=name)
edge = (1 - 2 * NU) / 3 + (4 + NU) * np.pi * FRICTION / 8
axes.plot(-1, edge, "o", color="black", markerfacecolor="white", label="Hamilton 1983")
axes.set_xlabel("$x/a$, sliding to the right")
axes.set_ylabel(r"$\sigma_{xx}/p_0$")
axes.legend(frameon=False)
trailing = float(fp.fields(BODY, TIP, -A, 0.0, 0.0, radius=A, friction=FRICTION).stress[0]) / peak

# %%
# Von Mises stress in the section of the coated body.

_, axes = plt.subplots(figsize=(6, 3.8), layout="constrained")
grid = np.meshgrid(np.linspace(-2, 2, 121) * A, np.linspace(0, 1.5, 81) * A)
section = fp.fields(COATED, TIP, grid[0], 0.0, grid[1], radius=A, friction=FRICTION)
fp.plot_fields(section, axes, medium=COATED)
print(f"trailing edge: {trailing:.6f}, Hamilton {edge:.6f}")
plt.show()
