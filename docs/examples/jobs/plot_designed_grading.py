r"""
A graded coating designed for a prescribed curve
================================================

Suresh 2001 (Science 292, 2447) showed what gradings of the modulus do for the resistance to contact damage. Here a grading is
designed backwards: six thin layers whose moduli give a sphere the force of a softer half-space at small depths and of a stiffer
one at large depths.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

TIP, BASE, COUNT, THICKNESS = fp.Sphere(100e-6), fp.HalfSpace(200e9, 0.3), 6, 1e-6
DEPTH = np.geomspace(10e-9, 1e-6, 8)

# %%
# The prescribed curve goes from that of 50 GPa to that of 130 GPa.

one = fp.indent(fp.HalfSpace(1e9, 0.3), TIP, depth=DEPTH, angles=1).force.values
wanted = one * np.geomspace(50, 130, DEPTH.size)
case = fp.Medium([fp.Layer(100e9, 0.3, THICKNESS)] * COUNT, base=BASE)
found = fp.design(
    case,
    TIP,
    vary={f"layers[{i}].young": (20e9, 400e9) for i in range(COUNT)},
    objective=fp.Target("force", wanted, depth=DEPTH),
    starts=1,
)
for note in found.notes:
    print(note)

# %%
# The moduli, and the force over that of a half-space of 100 GPa.

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
young = [layer.young / 1e9 for layer in found.medium.layers]
left.stairs(young, np.arange(COUNT + 1) * THICKNESS * 1e6, color="#1f4e79", baseline=None)
left.axhline(BASE.young / 1e9, color="#8c8c8c", linewidth=0.9)
left.set_xlabel("depth (µm)")
left.set_ylabel("Young's modulus (GPa)")
for values, style, name in (
    (wanted, "ko", "prescribed"),
    (found.achieved, "-", "designed"),
    (found.before, "--", "before"),
):
    right.semilogx(DEPTH * 1e9, values / (100 * one), style, markerfacecolor="none", label=name)
right.set_xlabel("indentation depth (nm)")
right.set_ylabel("force over that of 100 GPa")
right.legend(frameon=False)
plt.show()
