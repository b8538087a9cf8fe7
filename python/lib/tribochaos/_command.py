"""The command ``tribochaos``: the same program as the one that cargo builds."""

import signal
import sys

from . import _native


def main() -> None:
    """Carry out the command line of this process, and end it with the program's exit code."""
    # the program handles Ctrl-C itself; where it was ignored, as by nohup, it stays so
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_native.main(["tribochaos", *sys.argv[1:]]))
