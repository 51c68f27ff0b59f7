"""Derivatives of a contact by everything in the medium, from the pressures alone (T15.1).

The contact area is the one that makes the force largest, so its motion does not count:

    dF/dtheta |_d = - (1/4 pi^2) iint P* C_theta P d^2k,    dK/dtheta |_a = - (1/4 pi^2) iint P* C_theta P* d^2k,

P and P* the transforms of the contact pressure and of that of the flat punch on the same contact, per depth. The depth that
belongs to a contact radius follows the edge functional V in the same way. A `Spectrum` holds these weights over the wavenumber k;
the derivatives of C(k) come from `compliance.derivatives`.

What short waves add beyond the last k is known: C_theta is there a multiple h_theta of the half-space's compliance, whose
integrals are those of C, known in closed form, less those that are taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.compliances import Kernel
from flatpunch.compliances.derivatives import PartDerivatives, compliance_derivatives, energy_density
from flatpunch.media import (
    Body,
    Stack,
)
from flatpunch.sensitivities.parameters import Parameter, difference


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Weights of linear functionals of a change of C(k).

    Attributes
    ----------
    k : ndarray, shape (nk,)
        Wavenumbers [1/m].
    weights : ndarray, shape (functionals, nk)
        A change dC(k) changes the functionals by weights @ dC.
    totals : ndarray, shape (functionals,)
        The functionals of C itself, over all wavenumbers.
    """

    k: Array
    weights: Array
    totals: Array


def elastic_bodies(medium: Body) -> list[Stack]:
    """The deformable bodies of a medium, upper first."""
    return [body for body in medium.elastic if not body.power_law]


def by_medium(medium: Body, kernel: Kernel, spectrum: Spectrum, wanted: list[Parameter]) -> Array:
    """Derivatives of the functionals by parameters of a medium, shape (functionals, parameters)."""
    compliance = kernel(spectrum.k)
    rest = spectrum.totals - spectrum.weights @ compliance
    result = np.zeros((spectrum.totals.size, len(wanted)))
    for index, body in enumerate(elastic_bodies(medium)):
        share = kernel.modulus / body.surface_modulus
        mine = [(column, each) for column, each in enumerate(wanted) if each.body == index]
        parts = [_Weighted.of(part, spectrum.weights) for part in compliance_derivatives(body, spectrum.k)]
        for column, each in mine:
            part = parts[each.part]
            result[:, column] = part.derivative(each)
            if each.part == 0:
                result[:, column] -= share * _surface_change(each, body) * rest
    return result


def energy_shares(body: Stack, spectrum: Spectrum, depth: Array, layer: Indices, functional: int = 0) -> Array:
    """d(functional)/dln E(z) per length at depths of the given layers of one body, shape (nz,)."""
    return np.asarray(-spectrum.weights[functional] @ energy_density(body, spectrum.k, depth, layer))


@dataclass(frozen=True, slots=True)
class _Weighted:
    """Derivatives of the functionals by the constants of one layer at its depths; (functionals, nz) and (functionals,)."""

    depths: Array
    constants: dict[str, Array]
    thickness: Array

    @classmethod
    def of(cls, part: PartDerivatives, weights: Array) -> _Weighted:
        constants = {name: weights @ change.T for name, change in part.constants.items()}
        return cls(part.depths, constants, weights @ part.thickness)

    def derivative(self, parameter: Parameter) -> Array:
        if parameter.kind == "thickness":
            return self.thickness
        by_constant = self.constants[parameter.kind]
        if parameter.law is None:
            return by_constant[:, 0]
        return np.asarray(by_constant @ law_change(parameter, self.depths))


def law_change(parameter: Parameter, depths: Array) -> Array:
    """Change of a law of depth per change of one of its numbers, at depths, shape (nz,)."""
    make = parameter.law
    assert make is not None
    return difference(lambda value: np.asarray(make(value)(depths)), parameter.value, parameter.step)


def _surface_change(parameter: Parameter, body: Stack) -> float:
    """d ln E* at the surface of a body by one of its numbers in the top layer, or the base if there is none."""
    if parameter.kind not in body.parts[0].numbers:
        return 0.0
    change = 1.0 if parameter.law is None else float(law_change(parameter, np.zeros(1))[0])
    return change * body.parts[0].surface_slope(parameter.kind)
