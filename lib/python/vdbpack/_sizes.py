"""Distributions of radii, as `radius=` takes them."""

from __future__ import annotations

from typing import Any, Union

import numpy
import numpy.typing

from ._errors import ParameterError

__all__ = ["Sizes", "constant", "uniform", "normal", "lognormal", "table"]


class Sizes(str):
    """A distribution of radii as the command line writes it."""


class Table:
    """Radii and their weights, which go to a file for the run."""

    def __init__(self, radii: Any, weights: Any) -> None:
        self.radii = numpy.asarray(radii, float)
        self.weights = numpy.asarray(weights, float)
        if self.radii.ndim != 1 or self.radii.shape != self.weights.shape or self.radii.size == 0:
            raise ParameterError(
                f"table: radii of shape {self.radii.shape} and weights of shape {self.weights.shape}; "
                "as many of both are needed"
            )
        for name, values in (("radii", self.radii), ("weights", self.weights)):
            if not (numpy.isfinite(values).all() and (values > 0).all()):
                raise ParameterError(f"table: {name} must be finite and positive")

    def __repr__(self) -> str:
        return f"vdbpack.table of {self.radii.size} radii"

    def text(self) -> str:
        rows = (f"{r!r},{w!r}\n" for r, w in zip(self.radii.tolist(), self.weights.tolist()))
        return "radius,weight\n" + "".join(rows)


Radius = Union[str, float, Sizes, Table]


def constant(radius: float) -> Sizes:
    """Equal radii; mm."""
    return Sizes(f"constant:{float(radius)!r}")


def uniform(least: float, most: float) -> Sizes:
    """Radii evenly distributed from `least` to `most`; mm."""
    return Sizes(f"uniform:{float(least)!r},{float(most)!r}")


def normal(mean: float, deviation: float, least: float, most: float) -> Sizes:
    """Radii normally distributed, cut at `least` and `most`; mm."""
    return Sizes("normal:" + ",".join(repr(float(v)) for v in (mean, deviation, least, most)))


def lognormal(median: float, sigma: float, least: float, most: float) -> Sizes:
    """Radii whose logarithm is normally distributed, cut at `least` and `most`; mm, sigma a number."""
    return Sizes("lognormal:" + ",".join(repr(float(v)) for v in (median, sigma, least, most)))


def table(radii: numpy.typing.ArrayLike, weights: numpy.typing.ArrayLike) -> Table:
    """Single radii with weights, arrays of shape (K,); radii in mm.

    Weights are shares of the number of spheres, or with `weight_by="volume"` of their volume.
    """
    return Table(radii, weights)
