from .batch import Batch, fit_batch
from .case import FitCase, read_fit_case
from .distributions import plot_posterior
from .elastic.model import ForwardModel
from .films.film import FilmResult, fit_film, tenth_rule
from .films.oliver_pharr import Tip, oliver_pharr
from .films.unloading import Unloading, read_nanoindentation, tip_in_workbook, unloading, unloadings
from .fitting import fit, fit_ranges
from .half_space.correction import Correction, correct
from .half_space.formulas import compare_formulas
from .measured.curve import Curve, CurveError
from .measured.files.readers import read_curve
from .parameters.sample import Sample
from .parameters.scaling import parameter_names
from .parameters.settings import Free, Settings
from .pictures import plot_fit
from .plan import plan_scan, planned
from .reading import plot_measured
from .report.fitted import Profile
from .report.plans import Plan, PlanScan
from .report.posterior import LogNormal, Normal, Posterior, Uniform
from .report.result import FitResult
from .report.table import Estimate
from .together import Measured, fit_together

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
    "LogNormal",
    "Measured",
    "Normal",
    "Plan",
    "PlanScan",
    "Posterior",
    "Profile",
    "Sample",
    "Settings",
    "Tip",
    "Uniform",
    "Unloading",
    "compare_formulas",
    "correct",
    "fit",
    "fit_batch",
    "fit_film",
    "fit_ranges",
    "fit_together",
    "oliver_pharr",
    "parameter_names",
    "plan_scan",
    "planned",
    "plot_fit",
    "plot_measured",
    "plot_posterior",
    "read_curve",
    "read_fit_case",
    "read_nanoindentation",
    "tenth_rule",
    "tip_in_workbook",
    "unloading",
    "unloadings",
]
