"""Formulas in the depth z, read from text that nobody has to trust.

The reader is a recursive descent over numbers, z, + - * / ^ **, parentheses and a fixed list of functions. It
builds a tree of tuples and evaluates it with NumPy: no part of the text ever reaches the interpreter. Length and
nesting are bounded, and all arithmetic is in floats, so no formula can use much time or memory.

    sum     = product (("+" | "-") product)*
    product = sign (("*" | "/") sign)*
    sign    = ("+" | "-") sign | power
    power   = atom [("**" | "^") sign]
    atom    = number | "z" | "pi" | name "(" sum ("," sum)* ")" | "(" sum ")"
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, BadValue, shown
from flatpunch._support.readable import readable

LONGEST = 500
"""Largest number of characters in a formula."""

DEEPEST = 40
"""Largest nesting of parentheses, signs and powers."""

_FUNCTIONS: dict[str, tuple[int, Callable[..., Array]]] = {
    "exp": (1, np.exp),
    "log": (1, np.log),
    "sqrt": (1, np.sqrt),
    "abs": (1, np.abs),
    "sin": (1, np.sin),
    "cos": (1, np.cos),
    "tanh": (1, np.tanh),
    "sinh": (1, np.sinh),
    "cosh": (1, np.cosh),
    "atan": (1, np.arctan),
    "min": (2, np.minimum),
    "max": (2, np.maximum),
}
_OPERATORS: dict[str, Callable[..., Array]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "**": np.power,
}
_TOKEN = re.compile(
    r"[ \t]*(?:([0-9]++\.?[0-9]*+(?:[eE][+-]?[0-9]+)?|\.[0-9]+(?:[eE][+-]?[0-9]+)?)"
    r"|([A-Za-z_]+)|(\*\*|[-+*/^(),]))"
)

Tree = tuple[Any, ...]


@readable
@dataclass(frozen=True, slots=True)
class Formula:
    """Function of depth given by a formula in z, safe to read from a stranger's file.

    Parameters
    ----------
    text : str
        For example "1e9*exp(z/2e-6)"; z [m] from the layer's own top. Numbers, z, pi, + - * / ** (or ^),
        parentheses, and exp, log, sqrt, abs, sin, cos, tanh, sinh, cosh, atan of one argument, min and max of two.

    Raises
    ------
    ValueError
        If the text is no such formula; the message points at the place.

    See Also
    --------
    DepthTable : Measured values.
    GradedLayer : The layer that takes it.

    Examples
    --------
    >>> law = fp.Formula("2e9*(1 + exp(-z/1e-6))")
    >>> coating = fp.GradedLayer(young=law, poisson=0.3, thickness=3e-6)
    >>> print(f"{law(0.0):.1e} Pa at the surface of the layer, {law(3e-6):.1e} Pa at its foot")
    4.0e+09 Pa at the surface of the layer, 2.1e+09 Pa at its foot
    """

    text: str
    _tree: Tree = field(init=False, repr=False, compare=False, default=())

    def __post_init__(self) -> None:
        if not isinstance(self.text, str):
            raise TypeError(f"Formula.text = {shown(self.text)} must be a string, for example '1e9*exp(z/2e-6)'.")
        if len(self.text) > LONGEST:
            raise _bad(f"has {len(self.text)} characters; at most {LONGEST} are read. Give a table instead.")
        object.__setattr__(self, "_tree", _Reader(self.text).read())

    def __call__(self, z: Array) -> Array:
        """Values at depths z [m], same shape."""
        z = np.asarray(z, dtype=float)
        with np.errstate(
            all="ignore"
        ):  # overflow and division by zero give inf or nan, which the layer refuses with the depth
            return np.broadcast_to(np.asarray(_value(self._tree, z), dtype=float), z.shape).copy()


def _bad(text: str) -> BadValue:
    """What is wrong with the text of a formula."""
    return BadValue("Formula.text", "", text)


def _value(tree: Tree, z: Array) -> Array | np.float64:
    kind = tree[0]
    if kind == "number":
        return np.float64(tree[1])
    if kind == "z":
        return z
    operation = _OPERATORS[kind] if kind in _OPERATORS else _FUNCTIONS[kind][1]
    return operation(*(_value(branch, z) for branch in tree[1:]))


class _Reader:
    """Reads one formula; holds the tokens and the place of the next one."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens = self._split()
        self.next = 0
        self.depth = 0

    def read(self) -> Tree:
        tree = self._sum()
        if self.next < len(self.tokens):
            raise self._fault("an operator or the end")
        return tree

    def _split(self) -> list[tuple[str, str, int]]:
        tokens, place = [], 0
        end = len(self.text.rstrip(" \t"))
        while place < end:
            match = _TOKEN.match(self.text, place)
            if match is None:
                place += len(self.text[place:]) - len(self.text[place:].lstrip(" \t"))
                raise _bad(
                    f"{shown(self.text)}: character {place + 1} cannot be read. "
                    "A formula has numbers, z, pi, + - * / **, parentheses and a few functions."
                )
            kind = ("number", "name", "sign")[(match.lastindex or 1) - 1]
            tokens.append(
                (
                    kind,
                    match.group(match.lastindex or 1).replace("^", "**"),
                    match.start(match.lastindex or 1),
                )
            )
            place = match.end()
        return tokens

    def _sum(self) -> Tree:
        self._enter()
        tree = self._product()
        while (sign := self._take("+", "-")) is not None:
            tree = (sign, tree, self._product())
        self.depth -= 1
        return tree

    def _product(self) -> Tree:
        tree = self._sign()
        while (sign := self._take("*", "/")) is not None:
            tree = (sign, tree, self._sign())
        return tree

    def _sign(self) -> Tree:
        self._enter()
        sign = self._take("+", "-")
        if sign is None:
            tree = self._power()
        else:
            tree = ("-", ("number", 0.0), self._sign()) if sign == "-" else self._sign()
        self.depth -= 1
        return tree

    def _power(self) -> Tree:
        tree = self._atom()
        if self._take("**") is not None:
            return ("**", tree, self._sign())
        return tree

    def _atom(self) -> Tree:
        kind, word, _ = self.tokens[self.next] if self.next < len(self.tokens) else ("end", "", 0)
        if kind == "number":
            self.next += 1
            return ("number", self._number(word))
        if word == "(":
            return self._arguments(1)[0]
        if kind != "name":
            raise self._fault("a number, z, a function or '('")
        if word not in ("z", "pi") and word not in _FUNCTIONS:
            raise self._fault(f"z, pi, or one of {', '.join(sorted(_FUNCTIONS))}")
        self.next += 1
        if word == "z":
            return ("z",)
        if word == "pi":
            return ("number", float(np.pi))
        return (word, *self._arguments(_FUNCTIONS[word][0]))

    def _number(self, word: str) -> float:
        number = float(word)
        if not np.isfinite(number):
            raise _bad(f"{shown(self.text)}: the number {word} is too large.")
        return number

    def _arguments(self, count: int) -> list[Tree]:
        self._need("(")
        arguments = [self._sum()]
        while len(arguments) < count:
            self._need(",")
            arguments.append(self._sum())
        self._need(")")
        return arguments

    def _take(self, *signs: str) -> str | None:
        if self.next < len(self.tokens) and self.tokens[self.next][0] == "sign" and self.tokens[self.next][1] in signs:
            self.next += 1
            return self.tokens[self.next - 1][1]
        return None

    def _need(self, sign: str) -> None:
        if self._take(sign) is None:
            raise self._fault(f"'{sign}'")

    def _enter(self) -> None:
        self.depth += 1
        if self.depth > 2 * DEEPEST:
            raise _bad(f"is nested deeper than {DEEPEST} levels. Give a table instead.")

    def _fault(self, expected: str) -> ValueError:
        if self.next < len(self.tokens):
            _, word, place = self.tokens[self.next]
            return _bad(f"{shown(self.text)}: found '{word}' at character {place + 1}, expected {expected}.")
        return _bad(f"{shown(self.text)} ends where {expected} was expected.")
