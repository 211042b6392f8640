"""The few exceptions users meet. The command line turns each into one line on stderr and an exit code."""


class GfmdError(Exception):
    """Something went wrong while running."""

    exit_code = 1


class SceneError(GfmdError):
    """The scene, its files or the arguments are wrong; the message names the key, what was found and what is allowed."""

    exit_code = 2
