from typing import Any, Callable, Optional

import numpy
import numpy.typing

__version__: str

class LevelSetData:
    def array(
        self,
    ) -> tuple[numpy.typing.NDArray[numpy.float32], float, tuple[float, float, float]]: ...

class PackData:
    def __init__(
        self,
        positions: numpy.typing.ArrayLike,
        radii: numpy.typing.ArrayLike,
        columns: dict[str, Any],
        slice_height: float = 0.0,
    ) -> None: ...
    @property
    def positions(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def radii(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def columns(self) -> dict[str, Any]: ...
    @property
    def part_names(self) -> list[str]: ...
    @part_names.setter
    def part_names(self, names: list[str]) -> None: ...
    def pairs(
        self, tolerance: float
    ) -> tuple[numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.float64]]: ...
    @property
    def hash(self) -> str: ...
    @property
    def slice_height(self) -> Optional[float]: ...

class Option:
    name: str
    keyword: str
    type: str
    is_length: bool
    shown: str
    group: str
    help: str
    letter: str
    repeats: bool

def options() -> list[tuple[str, str, list[Option]]]: ...
def run(
    words: list[str],
    options: list[tuple[str, Optional[str]]],
    unset: list[str],
    inputs: dict[str, Any],
    progress: Optional[Callable[[str, float, float], None]],
) -> dict[str, Any]: ...
def read(file: str, unit: str, grid: str, columns: str, radius: float) -> PackData: ...
def write(pack: PackData, file: str, unit: str) -> None: ...
