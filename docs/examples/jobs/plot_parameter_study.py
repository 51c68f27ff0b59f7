r"""
Vary two values of a case
=========================

How does the force on cartilage depend on its thickness and on the size of the sphere? ``fp.sweep`` solves a case file for all
combinations of values; points that are solved are kept if a folder is given. The case is shipped as
``examples/indenter_on_cartilage.toml``.

On the command line: ``flatpunch sweep examples/indenter_on_cartilage.toml --vary "layers.0.thickness=0.4mm:2.4mm:12:log" --vary
"indenter.radius=1mm, 2mm, 4mm" --plot study.png``.
"""

import matplotlib.pyplot as plt

import flatpunch as fp

path = next(path for path in fp.files.shipped_cases() if path.stem == "indenter_on_cartilage")
study = fp.sweep(
    path, {"layers.0.thickness": "0.4mm:2.4mm:12:log", "indenter.radius": "1mm, 2mm, 4mm"}, workers=1, progress=False
)

# %%
# The study is an xarray dataset over the varied values and the steps of the case; here the force at the largest depth.

figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
for radius, style in zip(study["indenter.radius"].values, ("-", "--", ":"), strict=True):
    line = study.isel(step=-1).sel({"indenter.radius": radius})
    axes.semilogy(line["layers.0.thickness"] * 1e3, line.force, style, label=f"sphere of {radius * 1e3:g} mm")
axes.set_xlabel("thickness of the cartilage (mm)")
axes.set_ylabel(f"normal force at {float(study.depth.max()) * 1e3:.2g} mm (N)")
axes.set_yticks([0.5, 1, 2, 4], ["0.5", "1", "2", "4"])
axes.tick_params(axis="y", which="minor", labelleft=False)
axes.legend(frameon=False)
print(fp.sweeps.table(study).iloc[:3, :6].to_string(index=False))
plt.show()
