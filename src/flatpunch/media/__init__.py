"""Elastic bodies as data: layers, bases, media. No wavenumbers and no contact here."""

from flatpunch.media.bodies import HalfSpace, Layer, Medium, RigidBase
from flatpunch.media.formula import Formula
from flatpunch.media.graded import GradedLayer
from flatpunch.media.laws import Constant, DepthTable, ExponentialModulus, LinearModulus, PowerModulus
from flatpunch.media.material import AnyLayer, Homogeneous, Interface, Isotropic, Material
from flatpunch.media.membrane import Membrane
from flatpunch.media.relaxation import PowerLawRelaxation, Prony, Relaxation, StandardLinearSolid
from flatpunch.media.special_bodies import FreeLayer, PowerLawHalfSpace, TwoBodies
from flatpunch.media.stack import Base, Body, PunchSolution, Stack, TabulatedMedium, underlying
from flatpunch.media.transverse import TransverselyIsotropicHalfSpace, TransverselyIsotropicLayer, homogenised

__all__ = [
    "AnyLayer",
    "Base",
    "Body",
    "Constant",
    "DepthTable",
    "ExponentialModulus",
    "Formula",
    "FreeLayer",
    "GradedLayer",
    "HalfSpace",
    "Homogeneous",
    "Interface",
    "Isotropic",
    "Layer",
    "LinearModulus",
    "Material",
    "Medium",
    "Membrane",
    "PowerLawHalfSpace",
    "PowerLawRelaxation",
    "PowerModulus",
    "Prony",
    "PunchSolution",
    "Relaxation",
    "RigidBase",
    "Stack",
    "StandardLinearSolid",
    "TabulatedMedium",
    "TransverselyIsotropicHalfSpace",
    "TransverselyIsotropicLayer",
    "TwoBodies",
    "homogenised",
    "underlying",
]
