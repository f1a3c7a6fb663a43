"""Progress on a terminal, or wherever a callable takes it."""

from __future__ import annotations

import sys
from typing import Any, Callable, Optional, Union

Progress = Union[None, bool, Callable[[str, float, float], None]]


class Bar:
    """A bar by tqdm where it is installed, else a plain line."""

    def __init__(self) -> None:
        self.stage = ""
        self.bar: Any = None
        try:
            from tqdm import tqdm

            self.make: Any = tqdm
        except ImportError:
            self.make = None

    def __call__(self, stage: str, fraction: float, count: float) -> None:
        if self.make is None:
            print(f"\r{stage} {100 * fraction:3.0f} %\033[K", end="", file=sys.stderr, flush=True)
            return
        if stage != self.stage:
            self.close()
            self.stage = stage
            self.bar = self.make(total=100, desc=stage, leave=False, bar_format="{l_bar}{bar}| {elapsed}")
        self.bar.update(100 * fraction - self.bar.n)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()
            self.bar = None
        elif self.make is None:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def progress_of(wanted: Progress) -> Optional[Callable[[str, float, float], None]]:
    """What is called with a stage, its share that is done, and a count; None to be quiet."""
    if callable(wanted):
        return wanted
    shown = sys.stderr.isatty() or "ipykernel" in sys.modules if wanted is None else wanted
    return Bar() if shown else None
