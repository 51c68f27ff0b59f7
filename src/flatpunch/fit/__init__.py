"""From measured curves to layer properties: readers, fits, hard films, corrections of reported moduli, batches."""

from flatpunch.fit.curve import Curve, CurveError
from flatpunch.fit.fitting import Free, Settings, fit
from flatpunch.fit.forward import ForwardModel
from flatpunch.fit.hard_films import FilmResult, Tip, fit_film, oliver_pharr, tenth_rule
from flatpunch.fit.likelihood import Profile
from flatpunch.fit.nanoindentation import read_nanoindentation, tip_in_workbook
from flatpunch.fit.readers import read_curve
from flatpunch.fit.result import Estimate, FitResult
from flatpunch.fit.scaling import parameter_names

__all__ = [
    "Curve",
    "CurveError",
    "Estimate",
    "FilmResult",
    "FitResult",
    "ForwardModel",
    "Free",
    "Profile",
    "Settings",
    "Tip",
    "fit",
    "fit_film",
    "oliver_pharr",
    "parameter_names",
    "read_curve",
    "read_nanoindentation",
    "tenth_rule",
    "tip_in_workbook",
]
