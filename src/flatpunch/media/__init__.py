"""Elastic bodies as data: layers, bases, media. No wavenumbers and no contact here."""

from flatpunch.media.bodies import HalfSpace, Layer, Medium, RigidBase
from flatpunch.media.formula import Formula
from flatpunch.media.graded import GradedLayer
from flatpunch.media.laws import Constant, DepthTable, ExponentialModulus, LinearModulus, PowerModulus
from flatpunch.media.power_law import PowerLawHalfSpace
from flatpunch.media.relaxation import PowerLawRelaxation, Prony, Relaxation, StandardLinearSolid
from flatpunch.media.tabulated import PunchSolution, TabulatedMedium, underlying
from flatpunch.media.two_bodies import TwoBodies

Body = HalfSpace | Medium | PowerLawHalfSpace | TwoBodies | TabulatedMedium
"""What an indenter can be pressed into."""

__all__ = [
    "Body",
    "Constant",
    "DepthTable",
    "ExponentialModulus",
    "Formula",
    "GradedLayer",
    "HalfSpace",
    "Layer",
    "LinearModulus",
    "Medium",
    "PowerLawHalfSpace",
    "PowerLawRelaxation",
    "PowerModulus",
    "Prony",
    "PunchSolution",
    "Relaxation",
    "RigidBase",
    "StandardLinearSolid",
    "TabulatedMedium",
    "TwoBodies",
    "underlying",
]
