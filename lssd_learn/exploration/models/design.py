"""A formula and the columns it speaks of as a design matrix: terms, and rows for groups and slopes to be compared at.

Formulas are Wilkinson's, as in R, read by formulaic. Factors are coded by sums to zero, whatever the formula says of
them but for contrasts of its own: sums of squares of type III mean nothing otherwise, and the others do not depend on
it.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, cast

import numpy as np
import pandas as pd
from formulaic import Formula, ModelSpec, SimpleFormula
from formulaic.errors import FormulaicError
from formulaic.formula import OrderingMethod
from formulaic.parser.types import Factor, Term
from jaxtyping import Float

from lssd_learn.errors import InputError

ASKED = "task.formula"


@dataclass(frozen=True)
class ModelTerm:
    """A term of a formula.

    Attributes:
        name: as written.
        columns: of the design matrix.
        factors: what it is the product of, by name.
    """

    name: str
    columns: slice
    factors: frozenset[str]


@dataclass(frozen=True)
class Variable:
    """A number or a factor in a formula, such as log(size) or sex.

    Attributes:
        name: as written.
        column: of the frame that it is computed from.
        levels: of a factor, None of a number.
    """

    name: str
    column: str
    levels: tuple[str, ...] | None


@dataclass(frozen=True, eq=False)
class ModelDesign:
    """The design of n shapes.

    Attributes:
        formula: as written.
        X: (n, p) with the column of ones.
        terms: in the order of sums of squares of type I; the intercept is none of them.
        variables: by name.
        values: variable → (n,) its numbers or labels.
    """

    formula: str
    X: Float[np.ndarray, "n p"]
    terms: list[ModelTerm]
    variables: dict[str, Variable]
    values: dict[str, np.ndarray]
    _frame: pd.DataFrame
    _spec: ModelSpec

    @property
    def factors(self) -> list[str]:
        """The variables with levels."""
        return [name for name, variable in self.variables.items() if variable.levels is not None]

    @property
    def numbers(self) -> list[str]:
        """The variables that are numbers, each of one column."""
        return [name for name, variable in self.variables.items() if variable.levels is None]

    def containing(self, term: ModelTerm) -> list[ModelTerm]:
        """The terms that are products of this one and others."""
        return [other for other in self.terms if other.factors > term.factors]

    def groups(self, factors: Sequence[str]) -> list[tuple[str, ...]]:
        """The combinations of levels of some factors that there are shapes of."""
        there = set(zip(*(self.values[name] for name in factors), strict=True))
        levels = [self.variables[name].levels or () for name in factors]
        return [labels for labels in product(*levels) if labels in there]

    def mean_rows(self, factors: Sequence[str], groups: Sequence[tuple[str, ...]]) -> Float[np.ndarray, "g p"]:
        """Rows of the design at which groups have their least-squares means: numbers at the mean of all shapes, and of
        the other factors the mean over their levels."""
        return self._rows([dict(zip(factors, labels, strict=True)) for labels in groups])

    def slope_rows(
        self, number: str, factors: Sequence[str], groups: Sequence[tuple[str, ...]]
    ) -> Float[np.ndarray, "g p"]:
        """How these rows change as a number grows by one."""
        each = [dict(zip(factors, labels, strict=True)) for labels in groups]
        return self._rows([{**at, number: 1.0} for at in each]) - self._rows([{**at, number: 0.0} for at in each])

    def held(self, number: str) -> Float[np.ndarray, "n p"]:
        """The design (n, p) with a number at its mean for all shapes."""
        column = self.variables[number].column
        at = self._frame.assign(**{column: float(self.values[number].mean())})
        return np.asarray(self._spec.get_model_matrix(at), dtype=float)

    def _rows(self, places: Sequence[Mapping[str, Any]]) -> np.ndarray:
        """Means of the design over the levels of factors that are not said, one a place."""
        grids = [self._grid(place) for place in places]
        matrix = np.asarray(self._spec.get_model_matrix(pd.concat(grids, ignore_index=True)), dtype=float)
        return matrix.reshape(len(grids), -1, matrix.shape[1]).mean(1)

    def _grid(self, place: Mapping[str, Any]) -> pd.DataFrame:
        at: dict[str, list] = {}
        for column in self._frame.columns:
            values = self._frame[column].to_numpy()
            at[column] = [values.mean() if values.dtype.kind == "f" else values[0]]
        for name, variable in self.variables.items():
            if name in place:
                at[variable.column] = [place[name]]
            elif variable.levels is not None:
                at[variable.column] = list(variable.levels)
        return pd.DataFrame(list(product(*at.values())), columns=list(at))


def needed(formula: str, known: Sequence[str]) -> list[str]:
    """The names of the columns that a formula speaks of: of the known ones, and what it has to look up besides.

    Raises:
        InputError: no formula, one with a left side or in several parts, or without an intercept.
    """
    parsed = _parsed(formula)
    words = {word for term in parsed for factor in term.factors for word in _words(factor.expr)}
    return sorted(set(parsed.required_variables) | (words & set(known)))


def design(formula: str, columns: Mapping[str, np.ndarray], names: Sequence[str]) -> ModelDesign:
    """The design of n shapes.

    Args:
        formula: such as "~ log(size) + sex".
        columns: name → (n,) numbers, or objects that are labels; nothing unknown among them.
        names: n of the shapes, for messages.

    Raises:
        InputError: as `needed`; a function that is not there, a result that is no number, a factor of one level, more
            columns than shapes.
    """
    parsed = _parsed(formula)
    frame = pd.DataFrame({name: np.asarray(values) for name, values in columns.items()})
    state = _matrix(formula, parsed, frame)[1].encoder_state
    variables, written = {}, {}
    for factor in dict.fromkeys(factor for term in parsed for factor in term.factors):
        if factor.expr != "1":
            variables[factor.expr], written[factor.expr] = _variable(formula, factor, state, frame)
    terms = [":".join(written.get(factor.expr, factor.expr) for factor in term.factors) for term in parsed]
    X, spec = _matrix(formula, _of_terms(terms), frame)
    if not np.isfinite(X).all():
        i, j = np.argwhere(~np.isfinite(X))[0]
        raise InputError(f"{ASKED}={formula}: expected numbers, got {X[i, j]} for {names[i]}")
    found, first = [], 0
    for term, structure in zip(parsed, spec.structure, strict=True):
        columns_of = slice(first, first := first + len(structure.columns))
        if term.degree:
            found.append(ModelTerm(_name(term), columns_of, frozenset(factor.expr for factor in term.factors)))
    if not found:
        raise InputError(f"{ASKED}={formula}: expected a term to test, got the intercept alone")
    kept = {name: variable for name, variable in variables.items() if variable is not None}
    values = {name: frame[variable.column].to_numpy() for name, variable in kept.items()}
    return ModelDesign(formula, X, found, kept, values, frame, spec)


def _variable(
    formula: str, factor: Factor, state: Mapping[str, Any], frame: pd.DataFrame
) -> tuple[Variable | None, str]:
    """A factor of a formula as a variable, whose column is put into the frame, and how it is written for formulaic.

    What has several columns, as poly(age, 2), is none.
    """
    expr = factor.expr
    alias = f"variable_{len(frame.columns)}"
    quoted = expr if expr.isidentifier() else f"`{expr}`" if expr in frame else expr
    contrasts = state[expr][1].get("contrasts")
    if contrasts is None:
        values, _ = _matrix(formula, _of_terms([quoted]), frame)
        if values.shape[1] != 1:
            return None, quoted
        frame[alias] = values[:, 0]
        return Variable(expr, alias, None), alias
    levels: tuple[str, ...] = tuple(contrasts.levels)
    if len(levels) < 2:
        raise InputError(f"{ASKED}={formula}: expected two levels or more of {expr}, got {next(iter(levels))!r} alone")
    column = expr if expr in frame else _only(_words(expr) & set(frame.columns))
    if column is None:
        return None, quoted
    if expr in (column, f"C({column})"):
        frame[alias] = frame[column]
        return Variable(expr, alias, levels), f"C({alias}, contr.sum)"
    return Variable(expr, column, levels), quoted


def _words(expr: str) -> set[str]:
    """The names in a factor: formulaic tells none of those within poly, bs or center."""
    return {quoted or plain for quoted, plain in re.findall(r"`([^`]+)`|([^\W\d]\w*)", expr)} | {expr}


def _only(names: set) -> str | None:
    return next(iter(names)) if len(names) == 1 else None


def _name(term: Term) -> str:
    return ":".join(factor.expr for factor in term.factors)


def _parsed(formula: str) -> SimpleFormula:
    text = str(formula).strip()
    try:
        parsed = Formula.from_spec(text if text.startswith("~") else f"~ {text}")
    except FormulaicError as error:
        raise InputError(
            f"{ASKED}={formula}: expected a formula, such as ~ log(size) + sex: {_first(error)}"
        ) from error
    if not isinstance(parsed, SimpleFormula):
        raise InputError(f"{ASKED}={formula}: expected one right side, such as ~ log(size) + sex")
    if not any(term.degree == 0 for term in parsed):
        raise InputError(f"{ASKED}={formula}: expected a model with an intercept, leave out 0 and -1")
    return parsed


def _of_terms(terms: list[Any]) -> SimpleFormula:
    """In their order."""
    return cast(SimpleFormula, Formula.from_spec(terms, ordering=OrderingMethod.NONE))


def _matrix(formula: str, parsed: SimpleFormula, frame: pd.DataFrame) -> tuple[np.ndarray, Any]:
    """(n, p) float64 and its `ModelSpec`."""
    try:
        with np.errstate(all="ignore"):  # a logarithm of nothing is told with the name of its shape
            matrix = cast(Any, parsed.get_model_matrix(frame, na_action="ignore"))
    except FormulaicError as error:
        raise InputError(f"{ASKED}={formula}: {_first(error)}") from error
    return np.asarray(matrix, dtype=float), matrix.model_spec


def _first(error: Exception) -> str:
    return str(error).strip().splitlines()[0]
