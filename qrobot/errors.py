"""The one tree of errors that qRobot raises.

::

    QRobotError
    ├── InputError            bad input: names the file, the field, the value, the advice
    ├── InfeasibleError       no plan exists; carries the reason
    └── BackendError          a backend failed
        ├── MissingExtraError an optional dependency is absent; carries the install command
        ├── CredentialsError  a remote backend has no usable credentials
        └── RemoteError       a remote backend did not answer as it should

The command line turns each into one sentence and an exit code: 2 for `InputError`,
1 for `InfeasibleError`, 3 for `BackendError`. A traceback that reaches a user is a defect.
"""

from __future__ import annotations

__all__ = [
    "INSTALL",
    "BackendError",
    "CredentialsError",
    "InfeasibleError",
    "InputError",
    "MissingExtraError",
    "QRobotError",
    "RemoteError",
]

INSTALL = "pip install 'qrobot[{}]'"


class QRobotError(Exception):
    """Base of every error that qRobot raises on purpose."""

    exit_code = 3


class InputError(QRobotError, ValueError):
    """Something the user gave cannot be used.

    Parameters
    ----------
    problem
        What is wrong, as a clause: ``"weight -3 is negative"``.
    source
        The file it came from, when it came from one.
    field
        Path of the field inside the file, such as ``items[3].weight``.
    advice
        What the user can do about it, as a clause.
    """

    exit_code = 2

    def __init__(
        self,
        problem: str,
        *,
        source: str | None = None,
        field: str | None = None,
        advice: str | None = None,
    ) -> None:
        self.problem = problem
        self.source = source
        self.field = field
        self.advice = advice
        super().__init__(str(self))

    def __str__(self) -> str:
        where = ": ".join(part for part in (self.source, self.field) if part)
        text = f"{where}: {self.problem}" if where else self.problem
        return f"{text}; {self.advice}" if self.advice else text

    def in_file(self, source: str) -> InputError:
        """Return the same error with the file's name filled in."""
        return InputError(
            self.problem, source=self.source or source, field=self.field, advice=self.advice
        )

    def at(self, field: str | None) -> InputError:
        """Return the same error with another field."""
        return InputError(self.problem, source=self.source, field=field, advice=self.advice)


class InfeasibleError(QRobotError):
    """No plan exists for the instance.

    Parameters
    ----------
    reason
        One sentence that says why, with the numbers.
    proven
        True when the reason is a proof, False when no plan was found within the limits.
    """

    exit_code = 1

    def __init__(self, reason: str, *, proven: bool = True) -> None:
        self.reason = reason
        self.proven = proven
        super().__init__(reason)


class BackendError(QRobotError):
    """A backend could not do its work."""


class MissingExtraError(BackendError, ImportError):
    """A backend's software is not installed.

    Parameters
    ----------
    what
        What was asked for, such as ``"backend pyvrp"``.
    extra
        The extra of the `qrobot` distribution that installs it.
    """

    def __init__(self, what: str, extra: str) -> None:
        self.what = what
        self.extra = extra
        super().__init__(
            f"{what} needs software that is not installed; install it with: {INSTALL.format(extra)}"
        )


class CredentialsError(BackendError):
    """A remote backend has no usable credentials."""


class RemoteError(BackendError):
    """A remote backend failed, refused or did not answer in time."""
