"""A design as a problem of optimisation: residuals, limits and their exact derivatives, each evaluated once for each vector."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.contact.curve import Control
from flatpunch.contact.default import Method
from flatpunch.designs.targets import LargestLoad, Limit, Quantity, Target, achieved
from flatpunch.designs.variables import Variables
from flatpunch.sensitivities.gradient import gradients
from flatpunch.stresses import critical_load

LARGEST = float(np.log(1e50))
"""Logarithm in the place of an infinite critical load."""


@dataclass(eq=False)
class Problem:
    """Evaluations of targets and limits along a search.

    Attributes
    ----------
    variables : Variables
        What is varied.
    method : Method
        Contact method.
    evaluations : int
        Contacts or critical loads solved so far.
    refusal : str
        Why the last vector could not be evaluated, if it could not.
    limits : dict of bytes to tuple of str
        Why contacts are not valid, for the vectors at which some are not.
    """

    variables: Variables
    method: Method
    evaluations: int = 0
    refusal: str = ""
    limits: dict[bytes, tuple[str, ...]] = field(default_factory=dict)
    _known: dict[tuple[str | bytes, ...], object] = field(default_factory=dict)

    def quantity(self, u: Array, control: Control, quantity: Quantity) -> tuple[Array, Array]:
        """Values of a quantity, shape (n,), and derivatives of their logarithms by u, shape (n, variables)."""

        def solved() -> tuple[Array, Array]:
            medium, indenter = self.variables.case(u)
            self.evaluations += control.values.size
            found = gradients(medium, indenter, control, self.method, self.variables.renewed(medium, indenter))
            value, slope = achieved(found, control, quantity)
            if not all(each.valid for each in found):
                self.limits[u.tobytes()] = tuple(dict.fromkeys(each.notes for each in found if not each.valid))
            return value, self.variables.by_u(slope, u)

        # by content: targets and their controls come and go
        key = (control.name, control.values.tobytes(), quantity, u.tobytes())
        result: tuple[Array, Array] = self._once(key, solved)
        return result

    def residuals(self, u: Array, target: Target) -> tuple[Array, Array]:
        """Relative deviations ln(found/prescribed) and their derivatives; large ones where nothing can be solved."""
        try:
            value, slope = self.quantity(u, target.control, target.quantity)
        except ValueError as error:
            self.refusal = str(error)
            # residual where none can be computed, such as beyond the reach of a tip: the search then takes a shorter step
            return np.full(target.value.size, 1e3), np.zeros((target.value.size, u.size))
        return np.log(value / target.value), slope

    def margins(self, u: Array, limit: Limit) -> tuple[Array, Array]:
        """How far a limit is kept, >= 0 where it is, as logarithms, and derivatives by u."""
        value, slope = self.quantity(u, limit.control, limit.quantity)
        margins, slopes = [], []
        if limit.minimum is not None:
            margins.append(np.log(value[0] / limit.minimum))
            slopes.append(slope[0])
        if limit.maximum is not None:
            margins.append(np.log(limit.maximum / value[0]))
            slopes.append(-slope[0])
        return np.array(margins), np.array(slopes)

    def load(self, u: Array, aim: LargestLoad) -> float:
        """Logarithm of the critical load."""

        def solved() -> float:
            medium, indenter = self.variables.case(u)
            self.evaluations += 1
            first = critical_load(
                medium, indenter, aim.strengths, friction=aim.friction, residual_stress=aim.residual_stress
            )
            limiting = (
                f"The load is limited by {first.kind} of layer {first.layer + 1}." if first.force < np.inf else ""
            )
            self.limits[u.tobytes()] = (*filter(None, [limiting]), *first.notes)
            if first.force == 0:
                return -np.inf
            return float(np.log(first.force)) if np.isfinite(first.force) else LARGEST

        result: float = self._once(("load", u.tobytes()), solved)
        return result

    def _once(self, key: tuple[str | bytes, ...], solve: Callable[[], object]) -> Any:
        if key not in self._known:
            self._known[key] = solve()
        return self._known[key]
