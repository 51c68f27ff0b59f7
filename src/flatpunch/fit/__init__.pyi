from .batch import Batch, fit_batch
from .case import FitCase, read_fit_case
from .correction import Correction, correct
from .curve import Curve, CurveError
from .fitting import fit, fit_ranges
from .forward import ForwardModel
from .hard_films import FilmResult, fit_film, tenth_rule
from .likelihood import Profile
from .nanoindentation import read_nanoindentation, tip_in_workbook
from .oliver_pharr import Tip, oliver_pharr
from .readers import read_curve
from .result import Estimate, FitResult
from .sample import Sample
from .scaling import parameter_names
from .settings import Free, Settings
from .unloading import Unloading, unloading, unloadings

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
