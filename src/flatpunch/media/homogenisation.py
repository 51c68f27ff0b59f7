"""One transversely isotropic layer in the place of many thin ones (Backus 1962).

Waves that are long against the layers see the mean of the field equations over depth: of the coefficients of plane strain
(`plane.Plane`), compliances of stresses that are continuous across faces as well as stiffnesses of strains that are. Springs
at the faces between layers add their softness.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from flatpunch._support.checks import Array, shown
from flatpunch.media.material import AnyLayer
from flatpunch.media.plane import Plane, from_plane
from flatpunch.media.transverse import TransverselyIsotropicLayer

_NODES = 32
"""Gauss nodes between breaks of a law of depth."""


def homogenised(layers: Iterable[AnyLayer]) -> TransverselyIsotropicLayer:
    """Transversely isotropic layer with the static response of a stack of thin layers to long waves.

    Stacks of hundreds of layers (superlattices, laminates, sedimentary rock) then cost as much as one layer. The layer is as
    thick as all of them together and has the lower face of the last one.

    Parameters
    ----------
    layers : sequence of Layer, GradedLayer and TransverselyIsotropicLayer
        From the surface down, bonded to each other or joined by an Interface. One period of a periodic stack gives the constants
        of the whole.

    Returns
    -------
    TransverselyIsotropicLayer

    Raises
    ------
    ValueError, TypeError
        If there are none, or one slides on the next.

    See Also
    --------
    TransverselyIsotropicLayer : What it returns.
    Medium : Takes the layers themselves.

    Examples
    --------
    >>> pair = [fp.Layer(450e9, 0.2, 5e-9), fp.Layer(250e9, 0.3, 5e-9)]
    >>> coating = fp.homogenised(100 * pair)
    >>> print(f"{coating.young_in_plane / 1e9:.0f} GPa in the plane, {coating.young_axial / 1e9:.0f} GPa along z")
    351 GPa in the plane, 335 GPa along z

    Notes
    -----
    The response is that of the stack to waves that are long against a period; the error is of the first order in the wavenumber
    times the period, since the first layer is not the mean. The stiffness of a contact of radius a is off by a share of 0.05 to
    0.1 (moduli in a ratio of 1.8) to 0.6 (ratio 20) of the period over a; the page on media has the table. Stresses are means:
    s_zz, s_xz and s_yz are those in the stack, stresses along the layers differ from layer to layer.
    """
    stack = _checked(layers)
    thickness = sum(layer.thickness for layer in stack)
    total = sum(_integrated(layer) for layer in stack)
    for layer in stack[:-1]:
        along, across = layer.face.softness
        total = total + np.array(Plane(0.0, along, across, 0.0, 0.0))
    return TransverselyIsotropicLayer(
        *from_plane(Plane(*(np.asarray(total) / thickness).tolist())), thickness, stack[-1].bonded
    )


def _checked(layers: Iterable[AnyLayer]) -> list[AnyLayer]:
    if isinstance(layers, AnyLayer):
        raise TypeError("layers is one layer; give a list of layers.")
    stack = list(layers)
    if not stack:
        raise ValueError("layers is empty; give one layer at least.")
    for i, layer in enumerate(stack):
        if not isinstance(layer, AnyLayer):
            raise TypeError(
                f"layers[{i}] = {shown(layer)} must be a Layer, a GradedLayer or a TransverselyIsotropicLayer."
            )
        if i + 1 < len(stack) and not layer.bonded:
            raise ValueError(
                f"layers[{i}] slides on the next one: the stack has no shear stiffness and bends layer by layer, which no single "
                "layer does. Give Medium the layers themselves, or the interface a shear stiffness."
            )
    return stack


def _integrated(layer: AnyLayer) -> Array:
    """Coefficients of a layer, integrated over its depth."""
    if not layer.varies:
        return layer.thickness * np.array(layer.plane)
    x, w = np.polynomial.legendre.leggauss(_NODES)
    total = np.zeros(len(Plane._fields))
    for low, high in pairwise([0.0, *layer.breaks, layer.thickness]):
        z = low + (high - low) * (1 + x) / 2
        total += (high - low) / 2 * np.array(layer.plane_at(z)) @ w
    return total
