"""Exact second-order perturbation theory for slightly non-axisymmetric indenters on any medium (T8.1)-(T8.5)."""

from __future__ import annotations

from dataclasses import replace

from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import Control, Curve
from flatpunch.contact.perturbation import first_order
from flatpunch.contact.perturbation.error import estimates, second_order_error
from flatpunch.contact.perturbation.general_series import general_expansion
from flatpunch.contact.perturbation.power_law_series import power_expansion
from flatpunch.contact.perturbation.series_method import Expansion, solve_expansion
from flatpunch.indenters.profile import Indenter


def solve(kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
    """A whole curve; round indenters are solved exactly."""
    if indenter.round:
        return first_order.solve(kernel, indenter, control, phi)
    curve, contact = solve_expansion(kernel, indenter, expansion_of(kernel, indenter), control, phi)
    return replace(curve, extra=estimates(*second_order_error(indenter, contact)))


def expansion_of(kernel: Kernel, indenter: Indenter) -> Expansion:
    """The second-order series of an indenter on a medium."""
    if indenter.exponent is None:
        return general_expansion(kernel, indenter)
    return power_expansion(kernel, indenter, "second")
