"""Elastic bodies as data: layers, bases, media. No wavenumbers and no contact here."""

from flatpunch.media.bodies import AnyLayer, ElasticBase, HalfSpace, Layer, Medium, RigidBase
from flatpunch.media.formula import Formula
from flatpunch.media.free_layer import FreeLayer
from flatpunch.media.graded import GradedLayer
from flatpunch.media.homogenised import homogenised
from flatpunch.media.interface import Interface
from flatpunch.media.laws import Constant, DepthTable, ExponentialModulus, LinearModulus, PowerModulus
from flatpunch.media.power_law import PowerLawHalfSpace
from flatpunch.media.relaxation import PowerLawRelaxation, Prony, Relaxation, StandardLinearSolid
from flatpunch.media.tabulated import PunchSolution, Solid, TabulatedMedium, underlying
from flatpunch.media.transverse import TransverselyIsotropicHalfSpace, TransverselyIsotropicLayer
from flatpunch.media.two_bodies import TwoBodies

Body = Solid | TabulatedMedium
"""What an indenter can be pressed into."""

__all__ = [
    "AnyLayer",
    "Body",
    "Constant",
    "DepthTable",
    "ElasticBase",
    "ExponentialModulus",
    "Formula",
    "FreeLayer",
    "GradedLayer",
    "HalfSpace",
    "Interface",
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
    "Solid",
    "StandardLinearSolid",
    "TabulatedMedium",
    "TransverselyIsotropicHalfSpace",
    "TransverselyIsotropicLayer",
    "TwoBodies",
    "homogenised",
    "underlying",
]
