"""The errors that a user can cause or meet; the command line shows them without a traceback."""


class WarpRodsError(Exception):
    """Base of every error of this package; ``exit_code`` is what the command line returns for it."""

    exit_code = 1


class SceneError(WarpRodsError):
    """A scene that cannot be run as written: names each faulty key, its value and what is allowed."""

    exit_code = 2


class RunFolderError(WarpRodsError):
    """A run folder that holds a run already, or none, or one that does not fit the scene."""

    exit_code = 2


class RodFailure(WarpRodsError):
    """Rods that became non-finite or left their surface: names which, when, with what parameters."""


class UnknownReproduction(WarpRodsError):
    """A name that is none of the reproductions: lists those there are."""

    exit_code = 2
