"""From measured curves to layer properties: readers, fits, hard films, corrections of reported moduli, batches."""

from flatpunch.fit.batch import Batch, fit_batch
from flatpunch.fit.case import FitCase, read_fit_case
from flatpunch.fit.correction import Correction, correct
from flatpunch.fit.curve import Curve, CurveError
from flatpunch.fit.fitting import fit, fit_ranges
from flatpunch.fit.forward import ForwardModel
from flatpunch.fit.hard_films import FilmResult, fit_film, tenth_rule
from flatpunch.fit.likelihood import Profile
from flatpunch.fit.nanoindentation import read_nanoindentation, tip_in_workbook
from flatpunch.fit.oliver_pharr import Tip, oliver_pharr
from flatpunch.fit.readers import read_curve
from flatpunch.fit.result import Estimate, FitResult
from flatpunch.fit.sample import Sample
from flatpunch.fit.scaling import parameter_names
from flatpunch.fit.settings import Free, Settings
from flatpunch.fit.unloading import Unloading, unloading, unloadings

__all__ = [
    "Batch",
    "Correction",
    "Curve",
    "CurveError",
    "Estimate",
    "FilmResult",
    "FitCase",
    "FitResult",
    "ForwardModel",
    "Free",
    "Profile",
    "Sample",
    "Settings",
    "Tip",
    "Unloading",
    "correct",
    "fit",
    "fit_batch",
    "fit_film",
    "fit_ranges",
    "oliver_pharr",
    "parameter_names",
    "read_curve",
    "read_fit_case",
    "read_nanoindentation",
    "tenth_rule",
    "tip_in_workbook",
    "unloading",
    "unloadings",
]
