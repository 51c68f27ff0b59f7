"""A material file for slippy 0.5, which needs Python 3.9 and NumPy below 1.21: it carries the responses of one body as a table.

The table holds |q| times the entries of the surface compliance, as logarithms over ln |q|, and stresses at depths under waves of
traction along x; the file turns them into the direction of each wave. Beyond its ends, which are far from all lengths of the
body, both are straight lines. Influence coefficients of cells are those of one grid.
"""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch import kernels
from flatpunch._support.checks import CELLS, Array, values, whole
from flatpunch._support.whole_file import write_whole
from flatpunch.media import Body
from flatpunch.plugins.cases import module_path, shown_title

_PER_UNIT = 32
"""Nodes in one unit of ln |q|: cubics between them are good to 1e-8, since responses change over units."""

_BEYOND = 1e4
"""Largest and smallest wavelength of the table over all layers together and over the thinnest one."""

_TEMPLATE = '''"""{title}

A material for slippy, made by flatpunch: `material = LayeredMaterial("coating")`, used like `slippy.contact.Elastic`.
Write the file anew for another body or other depths of stresses.
"""

import base64
import io

import numpy as np
from scipy.interpolate import CubicSpline
from slippy.core import _IMMaterial

_TABLE = np.load(io.BytesIO(base64.b64decode({table!r})))
_S, _DEPTHS, _SPACING, _CELLS = (_TABLE[name] for name in ("s", "depths", "spacing", "cells"))
_SURFACE, _STRESS = (CubicSpline(_S, _TABLE[name]) for name in ("surface", "stress"))
# the sign of what couples z with x and y is that of slippy's own `Elastic`
_SIGN = (1, 1, -1)


def _at(spline, q):
    """Values at |q|, straight beyond the ends."""
    s = np.log(q)
    inside = np.clip(s, _S[0], _S[-1])
    beyond = (s - inside).reshape(s.shape + (1,) * (spline.c.ndim - 2))
    return spline(inside) + beyond * spline(inside, 1)


class LayeredMaterial(_IMMaterial):
    """{title}

    Parameters
    ----------
    name : str
        Name, each once.
    default_fft : bool
        Whether waves are used: for surfaces that repeat. Otherwise the influence of cells is, for which the file needs the grid.
    **options
        Of `_IMMaterial`: `periodic_im_repeats`, `zero_frequency_value`, ...
    """

    material_type = "LayeredMaterial"

    def __init__(self, name, default_fft=not _CELLS.size, **options):
        super().__init__(name, default_fft, **options)

    def _waves(self, grid_spacing, span):
        """|q|, its inverse scale at q = 0 replaced, and the axes along q, across it, and z."""
        y, x = (2 * np.pi * np.fft.fftfreq(n, d=step) for n, step in zip(span, grid_spacing))
        x, y = np.meshgrid(x, y)
        q = np.hypot(x, y)
        q[0, 0] = q[0, 1] if span[1] > 1 else q[1, 0]
        zero, one = np.zeros_like(q), np.ones_like(q)
        return q, ((x / q, y / q, zero), (-y / q, x / q, zero), (zero, zero, one))

    def _influence_matrix_frequency(self, components, grid_spacing, span):
        q, axes = self._waves(grid_spacing, span)
        f = _at(_SURFACE, q)
        n, a, c = np.moveaxis(np.exp(f[..., :3]) / q[..., None], -1, 0)
        d = f[..., 3] * np.sqrt(n * a)
        entries = {{(0, 0): a, (1, 1): c, (2, 2): n, (0, 2): 1j * d, (2, 0): -1j * d}}
        found = {{}}
        for name in components:
            # "xz" is the displacement along z under a load along x
            load, along = ("xyz".index(axis) for axis in name)
            total = sum(axes[i][along] * axes[j][load] * entry for (i, j), entry in entries.items())
            total = total * _SIGN[along] * _SIGN[load]
            total[0, 0] = self._mean(along, grid_spacing, span) if along == load else 0.0
            found[name] = total
        return found

    def _mean(self, along, grid_spacing, span):
        """Sum of the influence matrix over its span: that of the ground, and what layers add far from it."""
        s = _S[:2]
        n, a, c = np.exp(_SURFACE(s)[:, :3]).T
        (radial, across) = (n, 0 * n) if along == 2 else ((a + c) / 2, (a - c) / 2)
        # |q| C = ground + |q| rest
        (_, half), ((rest, ground), (_, turned)) = np.exp(s), (np.polyfit(np.exp(s), f, 1) for f in (radial, across))
        y, x = (m * step for m, step in zip(span, grid_spacing))
        # integrals of x^2/r^3 and y^2/r^3 over the span
        xx, yy = 2 * y * np.arcsinh(x / y), 2 * x * np.arcsinh(y / x)
        return (ground * (xx + yy) - turned * (xx - yy) * (1 if along == 0 else -1)) / (2 * np.pi) + rest

    def _influence_matrix_spatial(self, components, grid_spacing, span):
        waves = self._influence_matrix_frequency(components, grid_spacing, span)
        middle = tuple((m - 1) // 2 for m in span)
        found = {{name: np.roll(np.fft.ifft2(wave).real, middle, (0, 1)) for name, wave in waves.items()}}
        if "zz" in found and not self.use_frequency:
            rows, columns = (np.abs(np.arange(m) - middle[i]) for i, m in enumerate(span))
            if max(rows.max(), columns.max()) >= len(_CELLS) or not np.allclose(grid_spacing, _SPACING, rtol=1e-9, atol=0):
                raise ValueError(f"the file is for {{len(_CELLS) - 1}} cells of {{float(_SPACING)}} m at most; write it anew.")
            found["zz"] = _CELLS[np.ix_(rows, columns)]
        return found

    def _stresses(self, load, components, grid_spacing, span, z):
        """Stress under a load, transformed as slippy's sub model takes it, shape (nz, ny, nx) each."""
        z = [] if z is None else z
        near = [np.flatnonzero(np.isclose(_DEPTHS, depth, rtol=1e-9, atol=0)) for depth in np.ravel(z)]
        if not near or not all(map(len, near)):
            raise ValueError(f"z must be depths of this file, {{_DEPTHS.tolist()}} m; write it anew for others.")
        q, axes = self._waves(grid_spacing, span)
        chosen = [found[0] for found in near]
        f = np.moveaxis(_at(_STRESS, q), (-2, -1), (0, 1))[:, chosen]
        entries = {{
            (0, 0, 0): 1j * f[0], (1, 1, 0): 1j * f[1], (2, 2, 0): 1j * f[2], (0, 2, 0): f[3],
            (1, 2, 1): f[4], (0, 1, 1): 1j * f[5],
            (0, 0, 2): f[6], (1, 1, 2): f[7], (2, 2, 2): f[8], (0, 2, 2): 1j * f[9],
        }}
        found = {{}}
        for name in components:
            m, n = ("xyz".index(axis) for axis in name)
            total = 0
            for (i, j, wave), entry in entries.items():
                turned = axes[i][m] * axes[j][n] + (i != j) * axes[j][m] * axes[i][n]
                total = total + turned * axes[wave][load] * entry
            # the longest waves of the table, averaged over their direction
            even = {{(0, 0): (6, 7), (1, 1): (6, 7), (2, 2): (8, 8)}} if load == 2 else {{(load, 2): (3, 4)}}
            total[:, 0, 0] = _STRESS(_S[0])[list(even[m, n])][:, chosen].mean(axis=0) if (m, n) in even else 0.0
            found[name] = total
        return found

    def sss_influence_matrices_normal(self, components, grid_spacing, span, z=None, cuda=False):
        return self._stresses(2, components, grid_spacing, span, z)

    def sss_influence_matrices_tangential_x(self, components, grid_spacing, span, z=None, cuda=False):
        return self._stresses(0, components, grid_spacing, span, z)

    def sss_influence_matrices_tangential_y(self, components, grid_spacing, span, z=None, cuda=False):
        return self._stresses(1, components, grid_spacing, span, z)

    def __repr__(self):
        return f"LayeredMaterial({{self.name!r}})"
'''


def write_slippy_material(
    path: str | Path, medium: Body, *, title: str = "", depths: Any = (), spacing: float = 0.0, cells: int = 0
) -> Path:
    """Write a body as a material file for slippy.

    Parameters
    ----------
    path : path
        Target, a Python module such as "coating.py".
    medium : Body
        Layers and base; not two bodies.
    title : str
        What it is, in words.
    depths : sequence of float
        Depths [m] at which slippy may ask for stresses.
    spacing, cells : float, int
        Grid of contacts that do not repeat: side of the cells [m] and their number along the longer side. Without it such
        contacts are as accurate as those of slippy's half-spaces in the frequency domain, some per cent.

    Returns
    -------
    Path
    """
    path = module_path(path, "coating.py")
    z = values("depths", depths, unit="m", empty=True)
    cells = whole("cells", cells, 0, "It is the number of cells along the longer side.", most=CELLS)
    stored = io.BytesIO()
    green = kernels.influence_coefficients(medium, spacing, (cells + 1, cells + 1)) if cells else np.zeros((0, 0))
    thicknesses = [layer.thickness for _, body in medium.sides for layer in body.layers] or [1.0]
    longest, shortest = sum(thicknesses), min(thicknesses)
    low, high = -np.log(_BEYOND * longest), np.log(_BEYOND / shortest)
    s = np.linspace(low, high, int((high - low) * _PER_UNIT) + 1)
    surface, stress = _surface(medium, np.exp(s)), _stress(medium, np.exp(s), z)
    np.savez_compressed(stored, s=s, surface=surface, stress=stress, depths=z, spacing=np.array(spacing), cells=green)
    table = base64.b64encode(stored.getvalue()).decode()
    write_whole(path, _TEMPLATE.format(title=shown_title(title, "Layered material (flatpunch)"), table=table).encode())
    return path


def _surface(medium: Body, q: Array) -> Array:
    """Logarithms of |q| n, |q| a and |q| c, and d over the root of n and a, shape (nq, 4)."""
    c = kernels.surface_compliance(medium, q, np.zeros(1), rtol=0)
    n, a, across = (c[:, i, i].real for i in (2, 0, 1))
    return np.stack([np.log(q * n), np.log(q * a), np.log(q * across), c[:, 0, 2].imag / np.sqrt(n * a)], axis=-1)


def _stress(medium: Body, q: Array, z: Array) -> Array:
    """The ten stresses that differ from zero under waves along x, at depths, shape (nq, 10, nz)."""
    if not z.size:
        return np.zeros((q.size, 10, 0))
    _, stress = kernels.interior(medium, q, np.zeros(1), z)
    xx, yy, zz, yz, xz, xy = range(6)
    odd = [stress[..., i, 0].imag for i in (xx, yy, zz)] + [stress[..., xz, 0].real]
    across = [stress[..., yz, 1].real, stress[..., xy, 1].imag]
    even = [stress[..., i, 2].real for i in (xx, yy, zz)] + [stress[..., xz, 2].imag]
    return np.stack([*odd, *across, *even], axis=1)
