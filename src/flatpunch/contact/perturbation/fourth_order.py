"""Fourth-order perturbation theory for power-law indenters, in its Pade form (T8.11)."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

from flatpunch._support.checks import Array, Flags
from flatpunch.compliance import Kernel
from flatpunch.contact.curve import Control, Curve, first_failure
from flatpunch.contact.perturbation import first_order, second_order
from flatpunch.contact.perturbation.error import estimates, fourth_order_error
from flatpunch.contact.perturbation.power_law_series import power_expansion
from flatpunch.contact.perturbation.series_method import solve_expansion
from flatpunch.indenters.profile import Indenter


def solve(kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
    """A whole curve; steps at which the series is not sound fall back to second order, and a note says from where on."""
    if indenter.round:
        return first_order.solve(kernel, indenter, control, phi)
    check(indenter)
    curve, contact = solve_expansion(kernel, indenter, power_expansion(kernel, indenter, "fourth"), control, phi)
    curve = replace(curve, extra=estimates(*fourth_order_error(indenter, contact)))
    if contact.sound.all():
        return curve
    note = first_failure(
        ~contact.sound,
        curve.depth,
        "the fourth-order term is too large, or changes too fast with the size of the contact (strong asymmetry or a stiff "
        "film); these steps are second order. method='refined' holds there, at the cost of some seconds.",
    )
    return _merged(curve, second_order.solve(kernel, indenter, control, phi), contact.sound, note)


def check(indenter: Indenter) -> None:
    """Refuse shapes that are no power law."""
    if indenter.exponent is None:
        raise ValueError(
            f"method = 'fourth-order' needs a power-law shape f = r^n psi(phi); {type(indenter).__name__} is none. "
            "Choose 'second-order', 'refined' or 'bem'."
        )


def _merged(curve: Curve, fallback: Curve, keep: Flags, note: tuple[str, ...]) -> Curve:
    """`curve` where `keep` holds, `fallback` elsewhere."""
    arrays = {
        f.name: np.where(
            keep if getattr(curve, f.name).ndim == 1 else keep[:, None],
            getattr(curve, f.name),
            getattr(fallback, f.name),
        )
        for f in fields(curve)
        if isinstance(getattr(curve, f.name), np.ndarray)
    }
    extra = {
        name: (dims, np.where(keep, values, fallback.extra[name][1]), unit, text)
        for name, (dims, values, unit, text) in curve.extra.items()
    }
    notes = tuple(dict.fromkeys((*curve.notes, *fallback.notes, *note)))
    return replace(curve, **arrays, notes=notes, extra=extra)
