"""A bar of progress, where there is somebody to see it."""

from __future__ import annotations

import sys
import warnings
from contextlib import contextmanager
from typing import Any, Callable, Iterator, Optional, Union

Observer = Callable[[float], Any]
"""Is called with the part of the work that is done, from 0 to 1."""

Progress = Union[bool, Observer, None]


@contextmanager
def observed(progress: Progress, words: str) -> Iterator[Optional[Observer]]:
    """Give what a run is to call, by what the user asked for: a function of their own, a bar, or nothing."""
    if callable(progress):
        yield progress
        return
    if progress is False or (progress is None and not _is_watched()):
        yield None
        return
    try:
        with warnings.catch_warnings():
            # in a notebook without widgets it draws with characters instead
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        if progress is True:
            raise ImportError("progress=True needs the package tqdm: pip install tqdm") from None
        yield None
        return
    # a bar for a run of less than a second would only flicker
    bar = tqdm(total=1000, desc=words, delay=1.0, bar_format="{desc}: {percentage:3.0f}% |{bar}| {elapsed}<{remaining}")

    def observe(part: float) -> None:
        bar.update(int(1000 * part) - bar.n)

    try:
        yield observe
    finally:
        bar.close()


def _is_watched() -> bool:
    """Whether a person sees the output: in a terminal or a notebook."""
    shell = sys.modules.get("IPython")
    is_notebook = shell is not None and getattr(shell.get_ipython(), "kernel", None) is not None
    return is_notebook or sys.stderr is not None and sys.stderr.isatty()
