"""What the tests share."""

import os
import shutil
import sys
from pathlib import Path

import matplotlib
import pytest

matplotlib.use("Agg")


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """Every test runs in a folder of its own."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="session")
def program() -> str:
    """The program that cargo has built, or the command that the package brings."""
    built = os.environ.get("TRIBOCHAOS_PROGRAM")
    command = Path(sys.executable).with_name("tribochaos")
    found = built or (str(command) if command.exists() else shutil.which("tribochaos"))
    assert found, "neither the program nor the command is there"
    return found
