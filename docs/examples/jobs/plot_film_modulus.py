r"""
Modulus of a hard film on its substrate
=======================================

A nitride film on steel under a Berkovich tip, with the contact stiffness measured over depth. Hardness and wear of the tip enter
through the measured area function alone: what is elastic in a test that leaves an imprint is the stiffness, and only it is
fitted, with the layered body in the place of a half-space. The curve is shipped as ``examples/fit/hard_film.csv``; it is
synthetic, with 350 GPa.

On the command line: ``flatpunch fit-film examples/fit/hard_film.csv examples/fit/hard_film.toml --plot film.png``.
"""

import matplotlib.pyplot as plt

import flatpunch as fp
from flatpunch.fits import Tip, fit_film, tenth_rule

shipped = fp.files.shipped_cases()[0].parent / "fit"
test = fp.read_curve(shipped / "hard_film.csv")
tip = Tip.from_coefficients([24.5, 180.0])  # nm^2 over nm: a tip of about 30 nm radius
film = fp.Medium([fp.Layer(young=300e9, poisson=0.25, thickness=1e-6)], base=fp.HalfSpace(young=210e9, poisson=0.3))
result = fit_film(test, film, tip)
print(result)

# %%
# Half-space formulas for the same points give the modulus of film and steel together, which falls with depth. At a tenth of the
# thickness they are off by what ``tenth_rule`` gives.

figure, axes = plt.subplots(figsize=(6.4, 4.8), layout="constrained")
fp.plot_fit(result, axes)
rule = tenth_rule(result.case, tip)
print(f"error of the one-tenth rule for this film: {100 * rule.error:+.0f} %")
plt.show()
