"""From measured curves to layer properties: readers, fits, hard films, corrections of reported moduli, batches."""

from flatpunch.fit.curve import Curve, CurveError
from flatpunch.fit.fitting import Free, Settings, fit
from flatpunch.fit.forward import ForwardModel
from flatpunch.fit.likelihood import Profile
from flatpunch.fit.readers import read_curve
from flatpunch.fit.result import Estimate, FitResult
from flatpunch.fit.scaling import parameter_names

__all__ = [
    "Curve",
    "CurveError",
    "Estimate",
    "FitResult",
    "ForwardModel",
    "Free",
    "Profile",
    "Settings",
    "fit",
    "parameter_names",
    "read_curve",
]
