"""Derivatives of a contact by everything in the medium, from the pressures alone (T15.1), and round contacts, whose are known.

The contact area is the one that makes the force largest, so its motion does not count:

    dF/dtheta |_d = - (1/4 pi^2) iint P* C_theta P d^2k,    dK/dtheta |_a = - (1/4 pi^2) iint P* C_theta P* d^2k,

P and P* the transforms of the contact pressure and of that of the flat punch on the same contact, per depth. The depth that
belongs to a contact radius follows the edge functional V in the same way. A `Spectrum` holds these weights over the wavenumber k;
the derivatives of C(k) come from `compliance.derivatives`.

What short waves add beyond the last k is known: C_theta is there a multiple h_theta of the half-space's compliance, whose
integrals are those of C, known in closed form, less those that are taken.

At a given radius a the depth d(a) is the one without an edge singularity, S[c] = 0 for the coefficients c of the pressure. So a
change A_theta of the punch matrix moves it by e dd = v.A_theta c, v = A^-1 s, whose transform V = cos(ka)/pi + sum v_n j_2n(ka)
is known in closed form up to what layers add (see `punch.matrix`); (T15.5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from flatpunch._support.checks import Array, Indices
from flatpunch.compliances import Kernel
from flatpunch.compliances.derivatives import PartDerivatives, compliance_derivatives, energy_density
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.indenters.profile import Indenter
from flatpunch.media import (
    Body,
    Stack,
)
from flatpunch.media.paths import with_values
from flatpunch.punch.basis import half_space_diagonal
from flatpunch.punch.family import punch_family
from flatpunch.punch.graded import graded_matrices
from flatpunch.punch.matrix import remainder_rule, solve_round, sufficient_terms
from flatpunch.punch.wavenumbers import bessel_table, composite_gauss, panel_edges, spherical_bessel
from flatpunch.sensitivities.parameters import Parameter, difference
from flatpunch.stresses.axisymmetric.contact_load import contact_load


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


def by_medium(medium: Body, kernel: Kernel, spectrum: Spectrum, wanted: list[Parameter]) -> Array:
    """Derivatives of the functionals by parameters of a medium, shape (functionals, parameters)."""
    compliance = kernel(spectrum.k)
    rest = spectrum.totals - spectrum.weights @ compliance
    result = np.zeros((spectrum.totals.size, len(wanted)))
    for index, body in enumerate(body for body in medium.elastic if not body.power_law):
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


_WINDOW = 80.0, 15.0
"""Middle, above the highest order that is felt, and width of the window that ends oscillating integrals: exp(-225) is left."""


@dataclass(frozen=True, slots=True)
class Contact:
    """One contact and how it grows.

    Attributes
    ----------
    radius, depth, force, stiffness : float
        a [m], d [m], F [N], K = dF/dd [N/m].
    growth : float
        dd/da [-]; infinite under a flat end, whose contact does not grow.
    stiffening : float
        dK/da of the flat punch [N/m^2].
    """

    radius: float
    depth: float
    force: float
    stiffness: float
    growth: float
    stiffening: float


def contact_at(kernel: Kernel, indenter: Indenter, radius: float, depth: float) -> Contact:
    """The contact of a radius; under a flat end, of a depth."""
    a = np.array([radius])
    if indenter.flat:
        responses = punch_family(kernel).at(a / kernel.length if not kernel.homogeneous else a)
        stiffness = float(2 * np.pi * kernel.modulus * radius * responses.flat[0, 0])
        strength = float(1 / np.pi + responses.edge[0, 0])
        return Contact(radius, depth, stiffness * depth, stiffness, np.inf, _stiffening(kernel, strength))
    found = round_contact(kernel, mean_profile(indenter), a)
    strength = float(1 / np.pi + found.responses.edge[0, 0])
    return Contact(
        radius,
        float(found.depth[0]),
        float(found.force[0]),
        float(found.stiffness[0]),
        float(found.depth_slope[0]) / radius,
        _stiffening(kernel, strength),
    )


def _stiffening(kernel: Kernel, strength: float) -> float:
    """dK/da by Krein's identity."""
    return float(2 * np.pi**2 * kernel.modulus * strength**2)


def spectrum_of(kernel: Kernel, indenter: Indenter, contact: Contact, reach: float | None = None) -> Spectrum:
    """Weights of F at fixed depth, K and d at fixed radius: up to ka = `reach`, or as far as layers act."""
    a = contact.radius
    if kernel.graded or (reach is None and not kernel.homogeneous):
        waves = _waves_of_series(kernel, indenter, contact)
    else:
        waves = _waves(kernel, indenter, contact, reach or 0.0)
    load, punch, functional = waves.load, waves.punch, waves.functional
    pairs = np.stack([-punch * load, -(punch**2), functional * load / (2 * np.pi)]).sum(axis=1)
    weights = 2 * np.pi * pairs * waves.x / a**2
    return Spectrum(waves.x / a, weights, np.array([-contact.force, -contact.stiffness, 0.0]))


@dataclass(frozen=True, slots=True)
class _Waves:
    """Transforms on nodes x = ka times roots of their weights, so that products of two add up to integrals over x.

    The first row is the transform itself. Where products oscillate fast, both rows hold halves of it: the transform with
    spherical Bessel functions of the first kind, and with those of the second.
    """

    x: Array
    load: Array
    punch: Array
    functional: Array


def _waves(kernel: Kernel, indenter: Indenter, contact: Contact, reach: float) -> _Waves:
    """On a homogeneous surface, up to ka = `reach`, with the pressure itself, whose series ends before."""
    a, modulus = contact.radius, kernel.modulus
    flat, edge, first = np.array([1 / np.pi]), np.zeros(1), 0
    if not kernel.homogeneous:
        beta = a / kernel.length
        responses = solve_round(kernel, np.array([beta]), sufficient_terms(kernel, beta))
        flat, edge = responses.flat[0], responses.edge[0]
        first = first_panel(kernel.floor * beta)
    # ends on few levels, so that tables are shared
    last = float(4 * 2 ** (np.ceil(4 * np.log2(max(4.0, reach) / 4)) / 4))
    table = bessel_table(0, flat.size, first, last)
    root = np.sqrt(table.w)
    punch = modulus * a * (flat @ table.j)
    functional = (np.cos(table.x) / np.pi + edge @ table.j) / (1 / np.pi + float(edge[0]))
    if indenter.flat:
        load = contact.depth * punch
    else:
        load = contact_load(kernel, indenter, a, contact.depth, edge=False).transform(table.x / a)
    return _Waves(table.x, *((each * root)[None] for each in (load, punch, functional)))


def first_panel(floor: float) -> int:
    """Power of four at which panels over x begin."""
    return min(0, int(np.floor(np.log(floor) / np.log(4))))


def _waves_of_series(kernel: Kernel, indenter: Indenter, contact: Contact) -> _Waves:
    """From the series of the pressures, as far as layers act: products end as their means over an oscillation.

    However wide the contact is against the layers, the wavenumbers are some thousands. Derivatives of the solution with so many
    terms are exact with the pressure of as many.
    """
    a, beta = contact.radius, contact.radius / kernel.length
    terms = sufficient_terms(kernel, beta)
    responses = solve_round(kernel, np.array([beta]), terms)
    flat, edge = responses.flat[0], responses.edge[0]
    if indenter.flat:
        series = contact.depth * flat
    else:
        moments = mean_profile(indenter).moments(np.array([a]), terms).b[0]
        series = contact.depth * flat - np.linalg.solve(_matrix(kernel, beta, terms), moments)
    # a smooth window ends the oscillating half of the products: its own transform at their wavelength is below rounding
    middle = 2.3 * terms + _WINDOW[0]
    end = middle + 6 * _WINDOW[1]
    if kernel.series is not None:
        # end of the panels under a graded surface over that of the window: integrands fall like x^-3
        floor, last, growth = kernel.series.floor, 1e4 * end, 2.0
    else:
        floor, last, growth = kernel.floor, kernel.cutoff * beta, 1.0
    near = panel_edges(first_panel(floor * beta), min(end, max(last, 4.0)))
    # products oscillate twice as fast as the pressures: the nodes of a panel leave 1e-15 on a length of 8
    edges = [*np.union1d(near, np.arange(128.0, near[-1], 8.0))]
    while edges[-1] < last:
        edges.append(edges[-1] + min(growth * edges[-1], 3 * edges[-1] ** 2 / terms**2))
    x, w = composite_gauss(np.array(edges))
    window = scipy.special.erfc((x - middle) / _WINDOW[1]) / 2
    both = window < 1 - 1e-15
    j, y = spherical_bessel(2 * terms, x)[::2], np.zeros((terms, x.size))
    y[:, both] = _second_kind(2 * terms, x[both])[::2]
    roots = np.sqrt(w * np.stack([(1 + window) / 2, (1 - window) / 2]))
    modulus, strength = kernel.modulus, 1 / np.pi + float(edge[0])
    # sums of s_n/D_n j_2n over all n are cos(x)/pi; with Bessel functions of the second kind sin(x)/pi far out
    functional = np.stack([np.cos(x) / np.pi + edge @ j, np.sin(x) / np.pi + edge @ y]) / strength
    load, punch = (modulus * a * np.stack([c @ j, c @ y]) * roots for c in (series, flat))
    return _Waves(x, load, punch, functional * roots)


def _matrix(kernel: Kernel, beta: float, terms: int) -> Array:
    if kernel.graded:
        return np.asarray(
            graded_matrices(kernel, np.array([beta]), terms)[0, 0] + np.diag(half_space_diagonal(0, terms))
        )
    return np.asarray(remainder_rule(kernel, np.array([beta]), terms, 0).matrix()[0])


def _second_kind(orders: int, x: Array) -> Array:
    """Spherical Bessel functions y_0 ... y_(orders - 1) at x above the orders, shape (orders, n)."""
    y = np.empty((orders, x.size))
    y[0] = -np.cos(x) / x
    y[1] = (y[0] - np.sin(x)) / x
    for n in range(2, orders):
        y[n] = (2 * n - 1) / x * y[n - 1] - y[n - 2]
    return y


def by_tip(kernel: Kernel, indenter: Indenter, contacts: list[Contact], wanted: list[Parameter]) -> Array:
    """Derivatives by numbers of the tip, of F at fixed depth, K and d at fixed radius: shape (contacts, 3, parameters).

    Force and depth are linear in the profile, at fixed contact radius.
    """
    a, stiffness, depths, stiffening = (
        np.array([getattr(each, name) for each in contacts]) for name in ("radius", "stiffness", "depth", "stiffening")
    )
    found = np.zeros((len(contacts), 3, len(wanted)))
    if indenter.flat:
        found[:, 0], found[:, 1] = (stiffening * depths)[:, None], stiffening[:, None]
        return found
    for column, parameter in enumerate(wanted):

        def solved(value: float, name: str = parameter.path) -> Array:
            _, tip = with_values(None, indenter, {name: value})
            found = round_contact(kernel, mean_profile(tip), a)
            return np.stack([found.force, found.depth])

        force, depth = difference(solved, parameter.value, parameter.step)
        found[:, 0, column], found[:, 2, column] = force - stiffness * depth, depth
    return found
