"""What this package warns of."""


class TribochaosWarning(UserWarning):
    """What the command would warn of: a setting or a machine that may give doubtful results."""


class StoppedWarning(TribochaosWarning):
    """A run was stopped by Ctrl-C; what was finished is returned, and the rest is NaN."""
