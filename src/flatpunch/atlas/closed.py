"""Power-law half-spaces in the same words as the tables: here every punch is a closed form, at all radii."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, positive, values
from flatpunch.atlas.parameter import Parameter
from flatpunch.media import PowerLawHalfSpace
from flatpunch.punch.power_law import power_law_punch


class PowerLawTable:
    """Flat punches on E(z) = E_l (z/l)^k; beta = a/l may have any value > 0."""

    name = "power-law"
    title = "Half-space whose modulus is a power of depth (closed form, no data)"
    parameters = (
        Parameter("grading", "exponent k of E(z) = E_l (z/l)^k", -0.49, 0.99),
        Parameter("poisson", "Poisson ratio nu", 0.0, 0.5),
    )
    panels = ()
    beta_range = (0.0, float("inf"))
    bound = ROUNDING
    attributes: Mapping[str, object] = {"source": "Booker, Balaam and Davis 1985; Giannakopoulos and Suresh 1997"}

    def stiffness_and_moments(
        self, beta: float | Array, exponents: Sequence[float] = (), **parameters: float | Array
    ) -> tuple[Array, ...]:
        """Kbar and moments kappa_n [-], as `Table.stiffness_and_moments`; parameters `grading` and `poisson`."""
        names = {p.name for p in self.parameters}
        if set(parameters) != names:
            raise TypeError(
                f"The table 'power-law' takes grading and poisson beside beta, not {', '.join(parameters)}."
            )
        checked = [p.check(parameters[p.name]) for p in self.parameters]
        radius = values("beta", np.atleast_1d(beta), strict=True).reshape(np.shape(beta))
        radius, grading, poisson = np.broadcast_arrays(radius, *checked)
        wanted = [positive("exponent", n) for n in exponents]
        result = np.empty((1 + len(wanted), radius.size))
        pairs = np.stack([grading.ravel(), poisson.ravel()], axis=1)
        kinds, index = np.unique(pairs, axis=0, return_inverse=True)
        for i, (k, nu) in enumerate(kinds.tolist()):
            chosen = np.ravel(index) == i
            punch = power_law_punch(PowerLawHalfSpace(1.0, 1.0, k, nu))
            result[0, chosen] = punch.normalized_stiffness(radius.ravel()[chosen])
            for row, n in enumerate(wanted, 1):
                result[row, chosen] = punch.moment(n, radius.ravel()[chosen])
        return tuple(row.reshape(radius.shape) for row in result)

    def edge_coefficients(self, beta: float | Array, **parameters: float | Array) -> Array:
        """Edge strength [-]: its square is d(a Kbar)/da = (1 + k) Kbar."""
        stiffness = self.stiffness_and_moments(beta, (), **parameters)[0]
        return np.asarray(np.sqrt((1 + np.asarray(parameters["grading"])) * stiffness))
