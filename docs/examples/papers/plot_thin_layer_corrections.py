r"""
Thin-layer corrections of AFM: the published factors against the exact contact
==============================================================================

A tip feels the base through a thin sample. Laboratories divide the measured force by a published factor. Here the
factors of Dimitriadis et al. 2002, Garcia and Garcia 2018 and Long et al. 2011 stand beside the exact contact, for a
sphere, a cone and a four-sided pyramid. For pyramids there was no factor, so the cone's is in use; the last one is new.

Sources, all ranges, and the new formula: :doc:`/afm`.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp
from flatpunch.fits.half_space import published

# %%
# The published formulas, incompressible sample bonded to a rigid base. x is sqrt(R d)/h for paraboloids and d
# tan(alpha)/h for cones and pyramids of half opening angle alpha.

# %%
# The new one for pyramids, F = C E* tan(alpha) d^2 (1 + c1 x + ... + c5 x^5) up to x = 2. C belongs to the thick
# sample. The first coefficient is exact, 2 C N/pi with the moment N = int (1 - L) d(kh) of the layer (1.77022 bonded,
# 1.16758 sliding); the others are fitted to `refined`.

FORCE, PYRAMID, new_factor = published.PYRAMID_FORCE, published.PYRAMID, published.pyramid

# %%
# The exact factors. The unit of length is the thickness, that of pressure E*.


def layer(bonded=True, poisson=0.5):
    """Sample on a rigid base."""
    return fp.Medium([fp.Layer(1 - poisson**2, poisson, 1.0, bonded=bonded)], base=fp.RigidBase())


def paraboloid(x, **sample):
    """F over that of Hertz."""
    return fp.indent(layer(**sample), fp.Paraboloid(1.0), depth=x**2).force.values / (4 / 3 * x**3)


def cone(x, **sample):
    """F over that of Love."""
    return fp.indent(layer(**sample), fp.Cone(np.pi / 4), depth=x).force.values / (2 / np.pi * x**2)


def flat_end(x, **sample):
    """F over that of Boussinesq; x = a/h."""
    return np.array([fp.flat_punch(layer(**sample), a).normalized_stiffness for a in x])


def pyramid(x, sides=4, **sample):
    """F over that on a thick sample; second order corrected by boundary elements, 0.03 %."""
    tip = fp.Pyramid(sides=sides, inclination=np.pi / 4)
    return fp.indent(layer(**sample), tip, depth=x, method="refined").force.values / (FORCE[sides] * x**2)


# %%
# How far is each good?


def ranges(x, formula, exact, limits=(0.01, 0.05, 0.10)):
    """Largest x at which the error is still within each limit; 0 if it never is, the last x if it always is."""
    error = np.abs(formula / exact - 1)
    ends = [np.flatnonzero(error > limit) for limit in limits]
    return [float(x[-1]) if not end.size else float(x[end[0] - 1]) if end[0] else 0.0 for end in ends]


def comparisons(x):
    """(formula, tip, its values, exact values) of what is drawn."""
    rounded, conical, four = paraboloid(x), cone(x), pyramid(x)
    return [
        ("Dimitriadis et al. 2002", "sphere", published.dimitriadis(x, 0.5, True), rounded),
        ("Garcia & Garcia 2018", "sphere", published.garcia(x, "paraboloid"), rounded),
        ("Long et al. 2011, R = h", "sphere", published.long(x, 1.0), rounded),
        ("Garcia & Garcia 2018", "cone", published.garcia(x, "cone"), conical),
        ("the cone's factor", "four-sided pyramid", published.garcia(x, "cone"), four),
        ("new formula", "four-sided pyramid", new_factor(x, 4, True), four),
    ]


def others(x):
    """The rest of the table: no correction at all, sliding samples, cones as coded in AFM programs, flat ends."""
    nothing, slides = np.ones_like(x), (paraboloid(x, bonded=False), pyramid(x, bonded=False))
    gavara = 1 + 2 * 1.7795 / np.pi**2 * x + 16 * 1.7795**2 * x**2
    return [
        ("none", "sphere", nothing, paraboloid(x)),
        ("none", "cone", nothing, cone(x)),
        ("none", "four-sided pyramid", nothing, pyramid(x)),
        ("Gavara & Chadwick 2012, as coded", "cone", gavara, cone(x)),
        ("Garcia & Garcia 2018", "flat end", published.garcia(x, "flat"), flat_end(x)),
        ("Dimitriadis et al. 2002", "sphere, sliding", published.dimitriadis(x, 0.5, False), slides[0]),
        ("new formula", "four-sided pyramid, sliding", new_factor(x, 4, False), slides[1]),
        ("new formula", "three-sided pyramid", new_factor(x, 3, True), pyramid(x, 3)),
        ("new formula", "three-sided pyramid, sliding", new_factor(x, 3, False), pyramid(x, 3, bonded=False)),
    ]


def main():
    """Draw the picture and print the ranges."""
    x = np.geomspace(0.01, 2.0, 300)
    colours = {"sphere": "#1f4e79", "cone": "#c2571a", "four-sided pyramid": "#2a7f3f"}
    figure, (factors, errors) = plt.subplots(1, 2, figsize=(10.5, 4.9), layout="constrained")
    handles, count = {tip: [] for tip in colours}, dict.fromkeys(colours, 0)
    print(f"{'tip':28} {'formula':32} {'1 %':>6} {'5 %':>6} {'10 %':>6}")
    for name, tip, formula, exact in comparisons(x) + others(x):
        print(f"{tip:28} {name:32}", *(f"{end:6.2f}" for end in ranges(x, formula, exact)))
    for name, tip, formula, exact in comparisons(x):
        if not handles[tip]:
            handles[tip] += factors.loglog(
                x,
                exact,
                color=colours[tip],
                lw=5,
                alpha=0.35,
                label=f"{tip}: {'to 0.03 %' if 'pyramid' in tip else 'exact'}",
            )
        dash = ("--", ":", "-.")[count[tip]] if name != "new formula" else (0, (1, 0.6))
        count[tip] += 1
        handles[tip] += factors.loglog(x, formula, color=colours[tip], ls=dash, lw=1.6, label=name)
        errors.semilogx(x, 100 * (formula / exact - 1), color=colours[tip], ls=dash, lw=1.6)
    factors.set_ylabel("force / force on a thick sample")
    factors.set_title("Soft incompressible sample bonded to glass", fontsize=10.5)
    factors.set_ylim(0.9, 40)
    factors.set_yticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
    for band, shade in ((10, "0.94"), (5, "0.88"), (1, "0.78")):
        errors.axhspan(-band, band, color=shade, zorder=0, lw=0)
        errors.text(0.0315, band + 0.15, f"{band} %", fontsize=7, color="0.35", va="bottom")
    errors.set_ylim(-22, 22)
    errors.set_ylabel("error of the formula (%)")
    errors.set_title("How far each formula can be trusted", fontsize=10.5)
    for axes in (factors, errors):
        axes.set_xlim(0.03, 2)
        axes.set_xticks([0.05, 0.1, 0.2, 0.5, 1, 2], ["0.05", "0.1", "0.2", "0.5", "1", "2"])
        axes.minorticks_off()
        axes.set_xlabel(r"$\sqrt{Rd}/h$ (sphere),  $d\,\tan\alpha/h$ (cone, pyramid)")
    # one column for each tip
    longest = max(map(len, handles.values()))
    empty = plt.Line2D([], [], alpha=0, label=" ")
    columns = [handle for tip in colours for handle in handles[tip] + [empty] * (longest - len(handles[tip]))]
    figure.legend(handles=columns, loc="outside lower center", ncols=3, frameon=False, fontsize=9, handlelength=3.2)
    return figure


if __name__ == "__main__":
    picture = main()
    if len(sys.argv) == 2:
        picture.savefig(sys.argv[1], dpi=150, metadata={"Software": None})
