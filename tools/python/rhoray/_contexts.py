"""Threads that render, kept from call to call."""
import os
import threading

from rhoray import _core
from rhoray._errors import UsageError

_process = os.getpid()
_contexts = []
_contexts_guard = threading.Lock()


class Context:
    """Threads to render with: one set for each call that runs at the same time."""

    def __enter__(self):
        if os.getpid() != _process:
            raise UsageError("rhoray was imported before this process was forked: its threads are gone",
                             hint="start processes by multiprocessing.get_context('spawn')")
        with _contexts_guard:
            self.context = _contexts.pop() if _contexts else _core.RenderContext(0)
        return self.context

    def __exit__(self, kind, error, trace):
        if kind is None:  # after an error, another one is made
            with _contexts_guard:
                _contexts.append(self.context)
