r"""
Beads and cones pressed deep into gels
======================================

Beads are pressed into gels to half of the thickness or the radius, where strains are no longer small. The picture shows how much
too large or too small the force of linear theory with the true sphere is, beside finite elements of a neo-Hookean gel
(``finite_strain="neo-hookean"``). Gels that keep their volume (a) take less force than linear theory, most where they are thick;
gels that lose volume (b) take more, most where they are thin. Under sharp cones (c) strains are large at any depth: the angle
counts. 55 degrees are an AFM tip with a half opening angle of 35 degrees. Sharp pyramids (bars in c) have an estimate, the cone
with the same areas, with a larger error. A cone with a rounded apex (d) is a sphere where it is shallow and the sharp cone where
it is deep. Bands are the errors that results state. Two mistakes under beads cost more (e): a paraboloid in the place of the
sphere, and a half-space in the place of the layer. A Gent solid, whose stretch has a limit (f), takes more force than the
neo-Hookean one.
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


figure, ((closed, drained), (cones, caps), (mistakes, gent)) = plt.subplots(
    3, 2, figsize=(9.5, 11.5), layout="constrained"
)
colors = plt.get_cmap("viridis")(np.linspace(0, 0.9, len(RATIOS)))
for panel, poisson in ((closed, 0.5), (drained, 0.4)):
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
drained.set_title(r"(b) compressible, $\nu = 0.4$", loc="left")
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
for sides, marker in ((3, "^"), (4, "s")):
    for angle in (25, 35, 45, 55):
        tip = fp.Pyramid(sides, np.radians(angle))
        curve = fp.indent(gel(np.inf, 0.5), tip, depth=RADIUS, finite_strain="neo-hookean")
        factor = float(curve.strain_factor[0])
        equal = np.degrees(np.arctan(np.tan(np.radians(angle)) / np.sqrt(sides / np.pi * np.tan(np.pi / sides))))
        bar = 100 * float(curve.force_error[0]) / factor
        name = f"pyramid of {sides} faces" if angle == 25 else None
        cones.errorbar(equal, 100 * (1 / factor - 1), bar, fmt=marker, ms=4, color="0.3", capsize=2, lw=0.9, label=name)
cones.set_title(r"(c) sharp cones and pyramids, $\nu = 0.5$", loc="left")
cones.set_xlabel("angle of the cone, or of that with the same areas (degrees)")
cones.set_ylabel("error of the force of linear theory (%)")
cones.set_xlim(10, 60)
cones.legend(frameon=False, fontsize="small")

depth = np.geomspace(0.02, 20, 120)
for angle in (20, 35, 50):
    tip = fp.SpheroCone(np.radians(angle), RADIUS)
    curve = fp.indent(gel(np.inf, 0.5), tip, depth=depth * RADIUS, finite_strain="neo-hookean")
    error, band = 100 * (1 / curve.strain_factor - 1), 100 * curve.force_error / curve.strain_factor
    (line,) = caps.semilogx(depth, error, label=f"{angle} degrees")
    caps.fill_between(depth, error - band, error + band, color=line.get_color(), alpha=0.25, lw=0)
caps.set_title(r"(d) rounded cones, half-space, $\nu = 0.5$", loc="left")
caps.set_xlabel("depth / radius of the apex")
caps.set_ylabel("error of the force of linear theory (%)")
caps.legend(frameon=False, loc="upper left")
caps.set_xlim(0.02, 20)

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
mistakes.set_title(r"(e) other mistakes, $h = R$, $\nu = 0.5$", loc="left")
mistakes.set_xlabel("depth / radius")
mistakes.set_ylabel("error of the force (%)")

# force of a Gent solid over that of the neo-Hookean one, by scripts/finite_strain
STIFFER = {
    r"bead, $R = h$, $d = h/2$": {100: 0.69, 30: 2.36, 3: 34.39},
    r"bead, $R = 5\,h$, $d = 0.4\,h$": {100: 0.37, 30: 1.24, 10: 3.85, 3: 14.86},
    r"cone of 35 degrees, $d = 0.31\,h$": {100: 0.21, 30: 0.71, 10: 2.22, 3: 8.41},
    r"bead on a half-space, $d = R/2$": {100: 0.06, 30: 0.21, 10: 0.64, 3: 2.16},
}
for label, rise in STIFFER.items():
    gent.loglog(list(rise), list(rise.values()), "o-", ms=4, label=label)
gent.set_title(r"(f) limit stretch, Gent, $\nu = 0.4999$", loc="left")
gent.set_xlabel("$J_m$")
gent.set_ylabel("more force than neo-Hookean (%)")
gent.legend(frameon=False, fontsize="small")
for panel in (closed, drained, cones, caps, mistakes):
    panel.axhline(0, color="0.6", lw=0.8, zorder=0)
for panel in (closed, drained, mistakes):
    panel.set_xlim(0, 0.5)
