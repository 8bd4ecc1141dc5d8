"""What goes wrong, as Python exceptions with the library's words: what was asked, what was found, what to do."""


class Error(Exception):
    """The root of everything that the library raises on purpose."""


class InvalidInput(Error, ValueError):
    """An argument or a model that cannot be worked with."""


class IoError(Error, OSError):
    """A file that cannot be read or written."""


class SolverError(Error, ArithmeticError):
    """A solver that cannot go on: a NaN, a matrix that is not positive definite."""


class OutOfMemory(Error, MemoryError):
    """More memory is needed than there is."""


class Unsupported(Error, NotImplementedError):
    """Something meaningful that this build or this version does not do."""


class Cancelled(Error):
    """The work was stopped."""


class Warning(UserWarning):  # noqa: A001
    """The result may not be what was wanted; the text names the remedy."""
