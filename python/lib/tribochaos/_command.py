"""The command ``tribochaos``: the same program as the one that cargo builds."""

import signal
import sys

from . import _native


def main() -> None:
    """Carry out the command line of this process, and end it with the program's exit code."""
    # the program handles signals itself
    for name in ("SIGINT", "SIGPIPE"):
        if (number := getattr(signal, name, None)) is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL if name == "SIGINT" else signal.SIG_IGN)
    sys.exit(_native.main(["tribochaos", *sys.argv[1:]]))
