r"""
Soft gel in water: a sphere that sticks
=======================================

A colloidal probe on a polyacrylamide gel on glass, one micrometre thick, as it is used under living cells. The glass
sphere jumps into contact, is pressed in, and withdrawn until it jumps off. The case is shipped as
``examples/sphere_sticking_to_gel_in_water.toml``; its text says where the values come from, and which are assumed.

Whoever takes the gel for thick finds another force, another work of adhesion, and another modulus.
"""

import matplotlib.pyplot as plt

import flatpunch as fp

case = fp.read_case(next(path for path in fp.files.shipped_cases() if path.stem == "sphere_sticking_to_gel_in_water"))
gel, work = case.medium.layers[0], case.physics.work_of_adhesion
thick = fp.HalfSpace(gel.young, gel.poisson)

figure, axes = plt.subplots(figsize=(6.4, 4), layout="constrained")
for medium, label, colour in ((case.medium, "1 µm of gel on glass", "C0"), (thick, "thick gel", "0.55")):
    loop = fp.adhesion_loop(medium, case.indenter, work_of_adhesion=work, depth=100e-9, points=150)
    for branch, style in ((0, "-"), (1, "--")):
        part = loop.sel(step=loop.branch == branch)
        axes.plot(part.depth * 1e9, part.force * 1e9, style, color=colour, label=label if branch == 0 else None)
    lost = {name: loop.attrs[f"pull_off_{name}"] for name in ("depth", "force")}
    axes.plot(lost["depth"] * 1e9, lost["force"] * 1e9, "o", color=colour)
    axes.plot(loop.attrs["jump_in_depth"] * 1e9, loop.attrs["jump_in_force"] * 1e9, "s", color=colour, mfc="w")
    soft = fp.pull_off(medium, case.indenter, work_of_adhesion=work)
    print(f"{label}: lets go at {soft.force * 1e9:.3f} nN, or at {lost['depth'] * 1e9:.0f} nm under prescribed depth;")
    print(f"  {loop.attrs['energy_lost'] * 1e18:.0f} aJ are lost in a loop")
axes.axhline(0, color="0.85", lw=0.8, zorder=0)
axes.set_xlabel("depth (nm)")
axes.set_ylabel("force (nN)")
axes.set_title("solid: approach, dashed: withdrawal; square: jump-in, disc: pull-off", fontsize=9)
axes.legend(frameon=False)
