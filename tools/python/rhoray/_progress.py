"""Progress of long calls: a bar, or a function of the caller."""
import contextlib
import sys
import time

from rhoray._errors import UsageError


@contextlib.contextmanager
def shown(progress):
    """Gives the function of (phase, done, total) that an argument `progress` asks for, or None.

    progress: None; True for a bar on stderr; or the function itself. A total of 0 is not known yet.
    """
    if progress is None or progress is False:
        yield None
    elif progress is True:
        bar = _Bar()
        try:
            yield bar.show
        finally:
            bar.clear()
    elif callable(progress):
        yield lambda phase, done, total: progress(_without_unit(phase), done, total)
    else:
        raise UsageError(f"progress: {progress!r}; expected None, True, or a function of (phase, done, total)")


def _without_unit(phase):
    """"writing", of "writing (bytes)"."""
    return phase.rpartition(" (")[0] if phase.endswith(")") and " (" in phase else phase


class _Bar:
    """One line of text, drawn again at most ten times a second. Carriage returns work in notebooks, too."""

    def __init__(self):
        self._phase, self._time, self._width = None, 0.0, 0

    def show(self, phase, done, total):
        now = time.monotonic()
        if phase == self._phase and done != total and now - self._time < 0.1:
            return
        self._phase, self._time = phase, now
        text = _without_unit(phase)
        if total:
            share = min(1.0, done / total)
            text += f" [{'=' * int(30 * share):30}] {int(100 * share)} %"
        self._draw(text)

    def clear(self):
        self._draw("")
        self._draw("")

    def _draw(self, text):
        sys.stderr.write("\r" + text.ljust(self._width))
        sys.stderr.flush()
        self._width = len(text)
