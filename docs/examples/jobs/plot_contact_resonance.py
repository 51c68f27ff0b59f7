r"""
Contact resonance of a thin film
================================

The tip of a vibrating cantilever touches a film; the frequency rises with the stiffness of the contact, and the modulus follows
from it. The usual way back takes a half-space. Here the contact is that of the film on its wafer: normal stiffness from `indent`,
lateral stiffness from `partial_slip`. The beam is that of Euler and Bernoulli, clamped at one end.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import flatpunch as fp

LEVER, FREE, HEIGHT = 40.0, 170e3, 15 / 225  # N/m; Hz without contact; height of the tip over the length of the beam
SILICON = fp.HalfSpace(young=165e9, poisson=0.22)
TIP, FORCE = fp.Paraboloid(radius=150e-9), 500e-9


def sample(young, thickness):
    """The film on its wafer, or as a half-space, under a tip of silicon."""
    film = fp.Medium([fp.Layer(young, 0.25, thickness)], base=SILICON) if thickness else fp.HalfSpace(young, 0.25)
    return fp.TwoBodies(upper=SILICON, lower=film)


def stiffnesses(body):
    """Normal and lateral stiffness [N/m] of a contact that sticks, whatever its friction."""
    pulled = fp.partial_slip(body, TIP, friction=0.3, force=FORCE, tangential_force=0.0)
    return float(fp.indent(body, TIP, force=FORCE, angles=1).stiffness[0]), float(pulled.lateral_stiffness[0])


# %%
# At the tip a spring along the normal acts on the deflection, and one along the surface, at the height of the tip, on the slope.
# With lengths over that of the beam and stiffnesses over :math:`EI/L^3`, the conditions at the tip are
# :math:`w''' = \sigma w` and :math:`w'' = -\tau w'`. They are linear in :math:`\sigma`: each frequency has one normal stiffness.


def spring(x, tau):
    """Numerator and denominator of the sigma with which x is a mode; frequencies are in proportion to x^2."""
    c, s, ch, sh = np.cos(x), np.sin(x), np.cosh(x), np.sinh(x)
    one = -(x**2) * (c + ch) - tau * x * (s + sh)
    two = -(x**2) * (s + sh) + tau * x * (c - ch)
    return x**3 * (one * (c + ch) + two * (s - sh)), two * (c - ch) - one * (s - sh)


def frequency(normal, lateral):
    """Frequency [Hz] of the first mode over a contact with these stiffnesses [N/m]."""
    sigma, tau = 3 * normal / LEVER, 3 * lateral / LEVER * HEIGHT**2
    x = brentq(lambda x: np.dot(spring(x, tau), (1, -sigma)), 1.8, 4.69, xtol=1e-14)
    return FREE * (x / FIRST) ** 2


FIRST, PINNED = (brentq(lambda x, part=part: spring(x, 0.0)[part], 1.8, 4.6, xtol=1e-14) for part in (0, 1))
print(f"first mode: x = {FIRST:.4f} without contact, {PINNED:.4f} with a tip that cannot move")

# %%
# The thinner the film, the more of the wafer is in the frequency.
moduli = np.geomspace(2e9, 200e9, 9)
figure, axes = plt.subplots(figsize=(5.6, 3.8), layout="constrained")
for thickness in (20e-9, 50e-9, 200e-9, 0.0):
    rising = [frequency(*stiffnesses(sample(young, thickness))) for young in moduli]
    axes.semilogx(
        1e-9 * moduli, 1e-3 * np.array(rising), label=f"{thickness * 1e9:.0f} nm" if thickness else "half-space"
    )
axes.set_xlabel("modulus of the film (GPa)")
axes.set_ylabel("frequency of the first mode (kHz)")
axes.legend(title="thickness")

# %%
# And back: the modulus with which the contact has a frequency, here that of films of 8 GPa. The film returns its modulus; a
# half-space that vibrates alike is stiffer, as much as the contact feels of the wafer.


def modulus(measured, thickness):
    """Modulus [Pa] of a film of this thickness, or of a half-space, with a measured frequency [Hz]."""
    return brentq(lambda young: frequency(*stiffnesses(sample(young, thickness))) - measured, 1e9, 150e9, xtol=1e5)


thicknesses = np.geomspace(15e-9, 1e-6, 7)
measured = [frequency(*stiffnesses(sample(8e9, thickness))) for thickness in thicknesses]
apparent = [modulus(each, 0.0) for each in measured]
film = [modulus(*each) for each in zip(measured, thicknesses, strict=True)]
for thickness, frequent, young in list(zip(thicknesses, measured, apparent, strict=True))[::2]:
    print(f"{thickness * 1e9:4.0f} nm: {frequent / 1e3:.1f} kHz, as a half-space {young / 1e9:.2f} GPa")
print(f"with the film: 8 GPa to {max(abs(np.array(film) / 8e9 - 1)):.0e}")

figure, axes = plt.subplots(figsize=(5.6, 3.8), layout="constrained")
axes.semilogx(1e9 * thicknesses, 1e-9 * np.array(apparent), "o-", label="half-space")
axes.semilogx(1e9 * thicknesses, 1e-9 * np.array(film), "s-", label="film on silicon")
axes.set_xlabel("thickness of the film (nm)")
axes.set_ylabel("modulus from the frequency (GPa)")
axes.legend()

# %%
# What the spring along the surface adds to the frequency, on the film of 50 nm: almost nothing near :math:`x = \pi`, where the
# mode has no slope at the tip, and more beyond, the stiffer the contact.
print(f"no slope at {FREE * (np.pi / FIRST) ** 2 / 1e3:.1f} kHz")
for young in (8e9, 70e9):
    normal, lateral = stiffnesses(sample(young, 50e-9))
    more = frequency(normal, lateral) / frequency(normal, 0.0) - 1
    print(f"{young / 1e9:.0f} GPa: {normal:.0f} N/m along the normal, {lateral:.0f} N/m along the surface, {more:.2%}")
