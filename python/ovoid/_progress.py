# SPDX-License-Identifier: Apache-2.0
"""Bars for long work."""
import contextlib


@contextlib.contextmanager
def bar(wants_it, what="drawing"):
    """What is told the fraction that is done: a bar of tqdm's, where it is installed."""
    tqdm = None
    if wants_it:
        with contextlib.suppress(ImportError):
            from tqdm import tqdm
    if tqdm is None:
        yield None
        return
    with tqdm(total=100, desc=what, unit="%", bar_format="{desc} {bar} {n:.0f} %") as shown:
        yield lambda fraction: shown.update(100 * fraction - shown.n)
