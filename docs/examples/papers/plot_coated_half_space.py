r"""
Films on half-spaces: Gao, Chiu and Lee 1992, and what followed
===============================================================

The reduced modulus that a flat punch of radius a finds on a film of thickness t. Gao, Chiu and Lee (Int. J. Solids
Struct. 29, 2471) mix film and base with a weight :math:`I_0(t/a)`: left, the weight beside the exact derivative of the
stiffness by the film's modulus at equal moduli, which it is. It was made for small mismatch, though, and is used for
any. Perriot and Barthel 2004 and Bec et al. 2006 (right) were made for large mismatch.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import flatpunch as fp
from flatpunch.fits.half_space import published

NU = 0.3
FORMULAS = {
    "Gao et al. 1992": lambda y, ratio: published.gao(1 / y, ratio, 1.0, NU),
    "Perriot & Barthel 2004": lambda y, ratio: published.perriot_barthel(1 / y, ratio, 1.0),
    "Bec et al. 2006": lambda y, ratio: published.bec(1 / y, ratio, 1.0),
}


def exact(y, ratio):
    """Reduced modulus over that of the base, K/(2a), for a film `ratio` times stiffer; y = t/a."""
    share = 1 - NU**2
    medium = fp.Medium([fp.Layer(ratio * share, NU, 1.0)], base=fp.HalfSpace(share, NU))
    with warnings.catch_warnings():
        # a punch wider than a stiff film is thick would have to pull inside; its stiffness is what the formulas are for
        warnings.simplefilter("ignore", fp.FlatpunchWarning)
        return np.array([fp.flat_punch(medium, 1 / t).normalized_stiffness * ratio for t in y])


def intervals(y, formula, truth, limit):
    """Stretches of y in which the error stays within a limit."""
    good = np.concatenate([[0], np.abs(formula / truth - 1) <= limit, [0]])
    ends = np.flatnonzero(np.diff(good))
    return [(float(y[first]), float(y[last - 1])) for first, last in ends.reshape(-1, 2)]


if __name__ == "__main__":
    thickness = np.geomspace(0.05, 20, 30)
    figure, (weights, moduli, errors) = plt.subplots(1, 3, figsize=(12, 3.9), layout="constrained")

    step = 1e-3
    slope = (exact(thickness, 1 + step) - exact(thickness, 1 - step)) / (2 * step)
    weights.semilogx(thickness, published.gao(1 / thickness, 1.0, 0.0, NU), color="C2", label="Gao's weight $I_0$")
    weights.plot(thickness[::3], slope[::3], "o", color="C2", mfc="w", label="exact derivative")
    weights.legend(frameon=False)
    weights.set_title("equal moduli", fontsize=10)

    for ratio, colour in ((10.0, "#1f4e79"), (0.1, "#c2571a")):
        truth = exact(thickness, ratio)
        moduli.loglog(thickness, truth, color=colour, lw=4, alpha=0.4, label=f"film {ratio:g}: exact")
        for style, (name, formula) in zip(("--", ":", "-."), FORMULAS.items(), strict=True):
            values = formula(thickness, ratio)
            moduli.loglog(thickness, values, color=colour, ls=style, label=name if ratio > 1 else None)
            errors.semilogx(thickness, 100 * (values / truth - 1), color=colour, ls=style)
    moduli.set_title(f"modulus found / base, $\\nu = {NU}$", fontsize=10)
    moduli.legend(frameon=False, fontsize=7.5, loc="lower left")
    moduli.set_ylim(0.02, 14)
    for band, shade in ((10, "0.94"), (5, "0.88"), (1, "0.78")):
        errors.axhspan(-band, band, color=shade, zorder=0, lw=0)
    errors.set_ylim(-45, 45)
    errors.set_title("error of the formula (%)", fontsize=10)
    for axes in (weights, moduli, errors):
        axes.set_xlabel("film thickness / punch radius")
