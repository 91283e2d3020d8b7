"""Exceptions. They carry the sentences of the program."""


class Error(Exception):
    """What every function raises. `code` is the exit code of the program; `hint` says what to do."""

    def __init__(self, fact, code=2, hint=""):
        super().__init__(fact + (f"\nhint: {hint}" if hint else ""))
        self.fact = fact
        self.code = code
        self.hint = hint


class UsageError(Error, ValueError):
    """The call makes no sense: a wrong shape, an unknown field, a number out of range."""


class FileError(Error, OSError):
    """A file is missing, cannot be read, or is damaged."""


class ResourceError(Error, MemoryError):
    """There is no memory, disk space or thread left."""


def error_of(code, fact, hint):
    classes = {2: UsageError, 3: FileError, 4: FileError, 5: ResourceError, 7: UsageError}
    return classes.get(code, Error)(fact, code, hint)
