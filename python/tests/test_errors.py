"""Bad input: an exception at once, with the words of the program."""

import subprocess

import numpy as np
import pandas as pd
import pytest
import tribochaos as tc


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda m: m.map(zeta_k=[3.0, np.nan]), "zeta_k = NaN is out of range"),
        (lambda m: m.map(zeta_k=[3.0, np.inf]), "zeta_k"),
        (lambda m: m.map(zeta_k=[]), "has 0 values"),
        (lambda m: m.map(zeta_k=[3.0]), "has 1 values"),
        (lambda m: m.map(zeta_k=[3.0, 3.0]), "twice"),
        (lambda m: m.map(zeta_k=np.ones((3, 2))), r"shape \(3, 2\)"),
        (lambda m: m.map(zeta_k=np.array(["3", "4"])), "numbers are needed"),
        (lambda m: m.map(zeta_k=np.array([3 + 1j, 4])), "numbers are needed"),
        (lambda m: m.map(zeta_k=[3.0, 4000.0]), "zeta_k = 4000 is out of range"),
        (lambda m: m.map(zeta_k="3:5"), "is no axis"),
        (lambda m: m.map(zetak=[3.0, 4.0]), "did you mean `zeta_k`"),
        (lambda m: m.map(zeta_k=3.0), "needs an axis"),
        (lambda m: m.map(zeta_k=[3.0, 4.0], quantities=["lyapunof"]), "there is no quantity"),
        (lambda m: m.map(zeta_k=[3.0, 4.0], quantities="lyapunov"), "list of names"),
        (lambda m: tc.open("s.zarr", quantities="lyapunov"), "list of names"),
        (lambda m: m.point(zetak=3.0), "did you mean `zeta_k`"),
        (lambda m: m.point(h1="much"), "is no number"),
        (lambda m: m.point(h1=True), "is no number"),
        (lambda m: m.points({"zeta_k": [3.0, np.nan]}), "row 2, column zeta_k"),
        (lambda m: m.points({"zeta_k": ["a", "b"]}), "column zeta_k has the type"),
        (lambda m: m.points({"zetak": [3.0]}), "did you mean `zeta_k`"),
        (lambda m: m.points(pd.DataFrame({0: [3.0]})), "has no name"),
        (lambda m: m.points(pd.DataFrame({"zeta_k": [True, False]})), "column zeta_k has the type bool"),
        (lambda m: m.points({}), "empty"),
        (lambda m: m.points(None), "DataFrame or a mapping"),
        (lambda m: m.points(pd.DataFrame([[3, 4]], columns=["zeta_k", "zeta_k"])), "two columns have one name"),
        (lambda m: m.points({"zeta_k": [3.0]}, zeta_k=4.0), "is a column, and set"),
        (lambda m: m.points({"zeta_k": np.ma.array([3, 9, 4], mask=[0, 1, 0])}), "masked"),
        (lambda m: m.points({"zeta_k": pd.Series([3.0], index=[0]), "b": pd.Series([1.0], index=[1])}), "NaN"),
        (lambda m: m.map(zeta_k=np.ma.array([3, 3.5, 4], mask=[0, 1, 0])), "masked"),
        (lambda m: m.map(zeta_k=[3, 4], quantitites=["lyapunov"]), "did you mean quantities"),
        (lambda m: m.map(zeta_k=[3, 4], quantities=[1]), "list of names"),
        (lambda m: m.point(h1=10**400), "is no number"),
        (lambda m: m.onset("zetak"), "did you mean `zeta_k`"),
        (lambda m: m.onset("zeta_k", zeta_k=3.0), "set to a value as well"),
        (lambda m: m.onset("zeta_k", starts=[]), "no initial states"),
        (lambda m: m.onset("zeta_k", starts=[(np.nan, 0)]), "x0 = NaN is out of range"),
        (lambda m: m.bifurcation(zeta_k=[3, 4], starts=(0.1, 0.0)), "list of pairs"),
        (lambda m: m.bifurcation(zeta_k=[3, 4], starts=[(1e10, 0)]), "x0 = 10000000000 is out of range"),
        (lambda m: m.replace(periods=10**6).bifurcation(zeta_k="0:12:100"), "states are too many"),
        (lambda m: m.trajectory(periods=1_000_000, samples=4096), "whole number from 1 to 244"),
        (lambda m: m.melnikov(samples=10.5), "whole number"),
        (lambda m: m.melnikov(samples=2**40), "whole number"),
        (lambda m: m.melnikov(within=(0, 5)), "give along"),
        (lambda m: m.melnikov(along="zetak"), "did you mean `zeta_k`"),
        (lambda m: m.replace(tolerance=np.nan), "setting tolerance"),
        (lambda m: m.replace(damping=3.0), "there is none"),
        (lambda m: tc.Model(tc.Machine(tc.Machine.template()), zeta_k=3.0), "follows from the machine"),
        (lambda m: m.onset("h1"), "needs a range"),
        (lambda m: m.onset("zeta_k", spacing=-1.0), "onset_spacing -1 is out of range"),
        (lambda m: m.bifurcation(zeta_k=3.0), "needs one axis, and there are 0"),
        (lambda m: m.bifurcation(zeta_k=[3, 4], follow="along"), "up and down"),
        (lambda m: m.bifurcation(x0=[0, 1]), "x0 is varied"),
        (lambda m: m.section(k_w=0.01), "no attractor"),
        (lambda m: m.section(points=0), "out of range"),
        (lambda m: m.trajectory(samples=1), "out of range"),
        (lambda m: m.melnikov(b=-1.0), "homoclinic"),
        (lambda m: m.replace(periodes=10), "did you mean periods"),
        (lambda m: m.replace(periods=3), "periods = 3 is out of range"),
        (lambda m: m.replace(periods="many"), "setting periods"),
        (lambda m: m.replace(scheme="euler"), "setting scheme"),
        (lambda m: m.replace(backend="gpu", precision="f64").point(), "a GPU integrates in f32"),
        (lambda m: tc.Model("papier"), "there is no preset"),
        (lambda m: tc.Model(3.0), "a preset or a Machine"),
        (lambda m: tc.Machine("shaft_radius = 1"), "machine lacks"),
    ],
)
def test_bad_input_is_named(call, says):
    with pytest.raises(ValueError, match=says):
        call(tc.Model())


def test_the_words_are_those_of_the_program(program):
    ran = subprocess.run([program, "point", "--set", "h1=5000"], capture_output=True, text=True)
    assert ran.returncode == 2
    with pytest.raises(ValueError) as caught:
        tc.Model(h1=5000.0)
    assert str(caught.value) in ran.stderr


def test_what_the_command_warns_of_is_a_warning():
    with pytest.warns(tc.TribochaosWarning, match="use renormalise_every"):
        tc.Model(scheme="rk4", steps_per_period=50, periods=16, transient_periods=20, align_periods=5).point()
