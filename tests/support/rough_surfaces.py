"""Bodies and surfaces of the tests of rough contact."""

import numpy as np

import flatpunch as fp

E, NU = 1e9, 0.3
HALF_SPACE = fp.HalfSpace(E, NU)
STAR = E / (1 - NU**2)
H = 1e-6


def layer(thickness, young=E, poisson=NU, base=None, bonded=True):
    return fp.Medium([fp.Layer(young, poisson, thickness, bonded=bonded)], base=base or fp.RigidBase())


MEDIA = {
    "half-space": HALF_SPACE,
    "rigid": layer(3e-6),
    "elastic": layer(3e-6, base=fp.HalfSpace(5 * E, 0.2)),
}


def wavy(nx, wavelength_cells, amplitude, ny=8):
    x = np.arange(nx) * H
    return fp.Topography(amplitude * np.cos(2 * np.pi * x / (wavelength_cells * H)) * np.ones((ny, 1)), H)
