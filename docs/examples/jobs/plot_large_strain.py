r"""
Beads and cones pressed deep into gels
======================================

Beads are pressed into gels to half of the thickness or the radius, where strains are no longer small. The picture shows how much
too large or too small the force of linear theory with the true sphere is, beside finite elements of a neo-Hookean gel
(``finite_strain="neo-hookean"``). Gels that keep their volume (a) take less force than linear theory, most where they are thick;
gels that lose volume (b) take more, most where they are thin. Under sharp cones (c) strains are large at any depth: the angle
counts. 55 degrees are an AFM tip with a half opening angle of 35 degrees. Bands are the errors that results state. Panel d has
two mistakes under beads that cost more: a paraboloid in the place of the sphere, and a half-space in the place of the layer.
"""

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp

RADIUS, SHARE = 10e-6, np.linspace(0.005, 0.5, 100)
BEAD = fp.Sphere(RADIUS)
RATIOS = (0.1, 0.2, 0.5, 1.0, 2.0, np.inf)


def gel(ratio, poisson):
    """Layer of a thickness over the radius, or a half-space."""
    if ratio == np.inf:
        return fp.HalfSpace(5e3, poisson)
    return fp.Medium([fp.Layer(5e3, poisson, ratio * RADIUS)], base=fp.RigidBase())


figure, ((closed, drained), (cones, mistakes)) = plt.subplots(2, 2, figsize=(9.5, 8), layout="constrained")
colors = plt.get_cmap("viridis")(np.linspace(0, 0.9, len(RATIOS)))
for panel, poisson in ((closed, 0.5), (drained, 0.45)):
    for ratio, color in zip(RATIOS, colors, strict=True):
        depth = SHARE * min(ratio, 1) * RADIUS
        curve = fp.indent(gel(ratio, poisson), BEAD, depth=depth, finite_strain="neo-hookean")
        error, band = 100 * (1 / curve.strain_factor - 1), 100 * curve.force_error / curve.strain_factor
        label = "half-space" if ratio == np.inf else f"$h = {ratio:g}\\,R$"
        panel.plot(SHARE, error, color=color, label=label)
        panel.fill_between(SHARE, error - band, error + band, color=color, alpha=0.25, lw=0)
        print(f"nu = {poisson:g}, {label}: {float(error[-1]):+.1f} % at the largest depth")
    panel.set_xlabel("depth / smaller of thickness $h$ and radius $R$")
closed.set_title(r"(a) incompressible, $\nu = 0.5$", loc="left")
closed.set_ylabel("error of the force of linear theory (%)")
drained.set_title(r"(b) compressible, $\nu = 0.45$", loc="left")
drained.legend(frameon=False, title="thickness", loc="lower left")

angles = np.linspace(10, 60, 26)
for share, poisson, label in (
    (0, 0.5, "half-space"),
    (0.25, 0.5, "$d = h/4$"),
    (0.5, 0.5, "$d = h/2$"),
    (0, 0.45, r"half-space, $\nu = 0.45$"),
):
    sample, depth = (gel(1.0, poisson), share * RADIUS) if share else (gel(np.inf, poisson), RADIUS)
    error, band = [], []
    for angle in np.radians(angles):
        curve = fp.indent(sample, fp.Cone(inclination=angle), depth=depth, finite_strain="neo-hookean")
        error.append(100 * (1 / float(curve.strain_factor[0]) - 1))
        band.append(100 * float(curve.force_error[0] / curve.strain_factor[0]))
    (line,) = cones.plot(angles, error, label=label, ls="-" if poisson == 0.5 else "--")
    cones.fill_between(angles, np.subtract(error, band), np.add(error, band), color=line.get_color(), alpha=0.25, lw=0)
    print(f"cones, {label}: {error[5]:+.1f} % at 20 degrees, {error[-1]:+.1f} % at 60")
cones.set_title(r"(c) sharp cones, $\nu = 0.5$", loc="left")
cones.set_xlabel("angle between flank and surface (degrees)")
cones.set_ylabel("error of the force of linear theory (%)")
cones.set_xlim(10, 60)
cones.legend(frameon=False)

layer = gel(1.0, 0.5)
depth = SHARE * RADIUS
true = fp.indent(layer, BEAD, depth=depth, finite_strain="neo-hookean").force
for label, force, place in (
    ("paraboloid for the sphere", fp.indent(layer, fp.Paraboloid(RADIUS), depth=depth).force, (0.04, 19)),
    ("linear theory, true sphere", fp.indent(layer, BEAD, depth=depth).force, (0.12, -6)),
    ("half-space for the layer", fp.indent(fp.HalfSpace(5e3, 0.5), BEAD, depth=depth).force, (0.2, -42)),
):
    (line,) = mistakes.plot(SHARE, 100 * (force / true - 1))
    mistakes.annotate(label, place, color=line.get_color())
mistakes.set_title(r"(d) other mistakes, $h = R$, $\nu = 0.5$", loc="left")
mistakes.set_xlabel("depth / radius")
mistakes.set_ylabel("error of the force (%)")
for panel in (closed, drained, cones, mistakes):
    panel.axhline(0, color="0.6", lw=0.8, zorder=0)
for panel in (closed, drained, mistakes):
    panel.set_xlim(0, 0.5)
