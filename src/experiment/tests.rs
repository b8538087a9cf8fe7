use super::*;
use crate::design::Axis;
use crate::machine::TEMPLATE;

#[test]
fn an_experiment_survives_its_toml_form() {
    let mut request = Request::default();
    request.set.insert("omega_0".into(), 1.0 / 3.0);
    request.device.adapter = Some("llvmpipe".into());
    let experiment = request.resolve().unwrap();
    let again = Request::from_toml(&experiment.request().to_toml()).unwrap();
    assert_eq!(again.resolve().unwrap(), experiment);
    // the device is not part of what identifies the results
    let results = Request::from_toml(&experiment.to_toml()).unwrap().resolve().unwrap();
    assert!(results != experiment && results.has_results_of(&experiment));
    assert_eq!(results.device, Device::default());
}

#[test]
fn the_default_number_of_steps_is_the_scheme_s() {
    let mut request = Request::default();
    let steps = |request: &Request| {
        let settings = request.resolve().unwrap().settings;
        (settings.integration.scheme, settings.integration.steps_per_period)
    };
    assert_eq!(
        steps(&request),
        (Scheme::Taylor, Scheme::Taylor.default_steps_per_period())
    );
    request.integration.scheme = Some(Scheme::Rk4);
    assert_eq!(steps(&request), (Scheme::Rk4, 628));
    request.integration.steps_per_period = Some(100);
    assert_eq!(steps(&request), (Scheme::Rk4, 100));
}

#[test]
fn names_of_schemes_are_those_in_files() {
    for scheme in Scheme::ALL {
        assert_eq!(serde_json::to_value(scheme).unwrap(), scheme.name());
    }
}

#[test]
fn an_empty_file_is_the_default_experiment() {
    assert_eq!(Request::from_toml("").unwrap(), Request::default());
}

/// The axes that the manual names.
#[test]
fn the_default_map_is_the_manual_s() {
    let manual = include_str!("../../docs/command-line.md");
    let text = "The defaults are `zeta_k=0:12:300` and `h1=0:2:201`";
    assert!(manual.contains(text));
    let axes: Vec<Axis> = text
        .split('`')
        .filter(|part| part.contains('='))
        .map(|axis| Axis::parse(axis).unwrap())
        .collect();
    assert_eq!(Request::default_map().to_vec(), axes);
    assert_eq!(Request::default().resolve().unwrap().design.axes(), axes);
}

#[test]
fn bad_requests_are_refused_with_a_reason() {
    for (toml, reason) in [
        ("stepz = 3", "unknown field"),
        ("[integration]\nsteps = 3", "unknown field"),
        ("[set]\nzetak = 3", "did you mean `zeta_k`"),
        ("[set]\nzeta_k = 3", "leave one of the two out"),
        ("[set]\nb = nan", "out of range"),
        ("[integration]\nsteps_per_period = 7", "from 8"),
        ("[sampling]\nperiods = 0", "from 16"),
        ("[sampling]\nalign_periods = 500", "from 0 to 300"),
        ("[device]\nbackend = \"gpu\"\n[integration]\nprecision = \"f64\"", "f32"),
        ("[device]\nbackend = \"gpu\"\n[set]\nepsilon_0 = 1e-6", "too thin"),
        ("[integration]\nscheme = \"euler\"", "rk4"),
        (
            "[y]\nparameter = \"zeta_k\"\nstart = 0\nstop = 1\ncount = 5",
            "two axes are zeta_k",
        ),
        (
            "points = {columns = ['h1'], rows = [[0.1], [2000]]}",
            "row 2, column h1: h1 = 2000 is out of range",
        ),
        (
            "axes = []\npoints = {columns = ['h1'], rows = [[0.1], [0.2, 0.3]]}",
            "row 2 has 2 values for 1 columns",
        ),
        (
            "axes = []\npoints = {columns = ['h1'], rows = [[0.1]]}",
            "axes and points: leave one of the two out",
        ),
        ("[sampling.initial_box]\nx = [1, -1]\ny = [0, 1]", "lower end first"),
    ] {
        let message = Request::from_toml(toml)
            .and_then(|request| request.resolve())
            .unwrap_err()
            .to_string();
        assert!(message.contains(reason), "{toml}: {message}");
    }
}

#[test]
fn steps_and_renormalisations_too_far_apart_for_the_layer_are_warned_of() {
    let mut request = Request::default();
    request.integration.scheme = Some(Scheme::Rk4);
    assert!(request.resolve().unwrap().warnings().is_empty());
    request.set.insert("epsilon_0".into(), 1e-5);
    let warnings = request.resolve().unwrap().warnings();
    assert!(warnings[0].contains("--steps-per-period"));
    assert!(warnings[1].contains("--renormalise-every"));
    request.integration.scheme = None;
    assert!(request.resolve().unwrap().warnings().is_empty());
}

fn with_machine(x: &str, y: &str) -> Request {
    Request {
        axes: Some(vec![Axis::parse(x).unwrap(), Axis::parse(y).unwrap()]),
        machine: Some(Description::from_toml(TEMPLATE).unwrap()),
        ..Request::default()
    }
}

#[test]
fn an_experiment_with_a_machine_survives_its_toml_form() {
    for (x, y) in [
        ("shaft_speed_amplitude=50:300:5", "interference=1e-9:5e-9:4"),
        ("x0=-1:1:5", "youngs_modulus=1e11:2e11:3"),
    ] {
        let mut request = with_machine(x, y);
        request.set.insert("damping".into(), 500.0 / 3.0);
        request.set.insert("epsilon_0".into(), 0.02);
        let experiment = request.resolve().unwrap();
        let again = Request::from_toml(&experiment.to_toml()).unwrap().resolve().unwrap();
        assert_eq!(again, experiment);
        assert_eq!(again.to_toml(), experiment.to_toml());
        // if a quantity is an axis, its value in the file does not matter; every other value does
        let machine = request.machine.as_mut().unwrap();
        if machine.values.contains_key(&SiQuantity::Interference) {
            machine.values.insert(SiQuantity::Interference, 3e-9);
        }
        assert_eq!(request.resolve().unwrap() == experiment, y.starts_with("interference"));
        request.set.insert("damping".into(), 500.0);
        assert_ne!(request.resolve().unwrap(), experiment);
    }
}

#[test]
fn heat_and_wear_of_a_machine_are_seen_wherever_they_are() {
    let resolve = |request: &Request| request.resolve().unwrap();
    let mut request = with_machine("shaft_speed_amplitude=50:300:5", "wear_coefficient=0:1e-14:4");
    let wears = resolve(&request);
    assert!(wears.wears() && wears.has_heat_or_wear() && wears.settings.integration.scheme == Scheme::Radau);
    assert_eq!(wears.extent(Parameter::KW).0, 0.0);
    request.axes.as_mut().unwrap()[1] = Axis::parse("damping=0:500:4").unwrap();
    request.set.insert("wear_coefficient".into(), 0.0);
    assert!(!resolve(&request).wears() && resolve(&request).has_heat_or_wear());
    request.set.insert("wear_energy_share".into(), 1.0);
    assert!(!resolve(&request).has_heat_or_wear());
    assert_eq!(resolve(&request).settings.integration.scheme, Scheme::Taylor);
}

#[test]
fn what_does_not_go_with_a_machine_is_refused_with_a_reason() {
    let machine: String = TEMPLATE.lines().flat_map(|line| [line, "\n"]).collect();
    let axes = |x: &str, y: &str| {
        format!(
            "[x]\nparameter = \"{x}\"\nstart = 1\nstop = 2\ncount = 5\n[y]\nparameter = \"{y}\"\nstart = 1\nstop = \
             2\ncount = 5\n"
        )
    };
    for (toml, reason) in [
        (
            format!("[machine]\n{machine}"),
            "zeta_k follows from the machine: set shaft_speed_amplitude",
        ),
        (
            format!("{}[machine]\n{machine}", axes("x0", "gamma")),
            "gamma follows from the machine",
        ),
        (
            axes("damping", "inertia"),
            "damping is a quantity of a machine, and there is none",
        ),
        (
            "[set]\ninertia = 1".to_owned(),
            "inertia is a quantity of a machine, and there is none",
        ),
        (
            format!("{}[set]\nb = 2\n[machine]\n{machine}", axes("x0", "damping")),
            "b follows from the machine: set tangent_cubic_stiffness",
        ),
        (
            format!("{}[set]\ndamping = 2\n[machine]\n{machine}", axes("x0", "damping")),
            "leave one of the two out",
        ),
        (
            format!("{}[machine]\n{machine}", axes("damping", "damping")),
            "two axes are damping",
        ),
        (
            format!("{}[machine]\nshaft_radius = 1e-3", axes("x0", "damping")),
            "the machine lacks bush_radius",
        ),
        (
            format!("{}[machine]\n{machine}", axes("x0", "length")),
            "length belongs to whole parts",
        ),
        (
            format!("{}[set]\nlength = 1\n[machine]\n{machine}", axes("x0", "damping")),
            "length belongs to whole parts",
        ),
        (
            format!("{}[machine]\nrubbish = 1", axes("x0", "damping")),
            "unknown quantity `rubbish`",
        ),
    ] {
        let message = Request::from_toml(&toml)
            .and_then(|request| request.resolve())
            .unwrap_err()
            .to_string();
        assert!(message.contains(reason), "{reason}: {message}");
    }
}

#[test]
fn an_unlikely_machine_is_warned_of_over_the_whole_map() {
    let warnings = with_machine("interference=5e-6:1e-8:5", "damping=1:2:3")
        .resolve()
        .unwrap()
        .warnings();
    assert!(
        warnings.iter().any(|warning| warning.contains("interference = 10 nm")),
        "{warnings:?}"
    );
    assert!(
        warnings
            .iter()
            .any(|warning| warning.contains("wells lie at angles of 1.000 rad"))
    );
    let soft = with_machine("tangent_cubic_stiffness=-1e11:1e10:5", "damping=1:2:3")
        .resolve()
        .unwrap()
        .warnings();
    assert!(
        soft.iter()
            .any(|warning| warning.contains("is not positive: the springs do not hold")),
        "{soft:?}"
    );
}

#[test]
fn a_misspelt_name_in_a_file_is_reported_with_its_line() {
    for toml in [
        "[set]\nh1 = 0.5\nzetak = 3.9\n",
        "[sampling]\nperiods = 99\nperiode = 99\n",
        "[[axes]]\nstart = 0\nparameter = \"zetak\"\nstop = 1\ncount = 5\n",
    ] {
        let message = Request::from_toml(toml).unwrap_err().to_string();
        assert!(message.contains("at line 3, "), "{message}");
    }
}

#[test]
fn slow_conduction_asks_for_more_heat_modes() {
    let warnings = |omega_tilde: f64, modes: Option<u32>| {
        let mut request = Request::default();
        for (name, value) in [
            ("gamma", 1.87),
            ("k_w", 0.01),
            ("biot", 10.0),
            ("omega_tilde", omega_tilde),
        ] {
            request.set.insert(name.to_owned(), value);
        }
        request.integration.modes = modes;
        request.resolve().unwrap().warnings().join(" ")
    };
    assert_eq!(warnings(0.1, Some(12)), "");
    assert!(
        warnings(0.024, Some(12)).contains("use --modes 24 or more"),
        "{}",
        warnings(0.024, Some(12))
    );
    assert_eq!(warnings(0.024, Some(24)), "");
    assert_eq!(warnings(0.024, None), "");
    assert!(warnings(0.001, None).contains("even 64 modes"));
}

#[test]
fn what_version_0_1_wrote_is_still_read() {
    let old = "[x]\nparameter = 'zeta_k'\nstart = 3.0\nstop = 5.0\ncount = 11\n[set]\nb = 2.0\n";
    let request = Request::from_toml(old).unwrap();
    let [x, y] = &request.axes.as_ref().unwrap()[..] else {
        panic!("two axes")
    };
    assert_eq!(*x, Axis::parse("zeta_k=3:5:11").unwrap());
    assert_eq!(*y, Request::default_map()[1]);
    assert_eq!(request.set["b"], 2.0);

    let old = "[settings]\nscheme = 'rk4'\nperiods = 99\nbackend = 'cpu'\naudit = 7\n[settings.initial_box]\nx = [0, 1]\ny = [0, 2]\n";
    let request = Request::from_toml(old).unwrap();
    assert_eq!(request.integration.scheme, Some(Scheme::Rk4));
    assert_eq!(
        (request.sampling.periods, request.sampling.initial_box.y),
        (99, [0.0, 2.0])
    );
    assert_eq!(
        (request.device.backend, request.checking.audit),
        (BackendChoice::Cpu, Some(7))
    );
    let error = Request::from_toml("[settings]\nperiode = 99").unwrap_err().to_string();
    assert!(error.contains("unknown field `periode`"), "{error}");
}

#[test]
fn what_a_file_leaves_out_of_the_sampling_is_the_commands_own() {
    let own = Sampling {
        transient_periods: 500,
        ..Sampling::default()
    };
    let request = Request::from_toml_over(
        "command = 'poincare'\n[sampling]\nseed = 3\n[options]\npoints = 9\n",
        own,
    );
    let request = request.unwrap();
    assert_eq!((request.sampling.transient_periods, request.sampling.seed), (500, 3));
    assert_eq!(Request::from_toml(&request.to_toml()).unwrap(), request);
}

#[test]
fn an_experiment_of_any_design_is_read_back_from_its_toml() {
    for toml in [
        "",
        "axes = []",
        "[[axes]]\nparameter = 'gamma'\nspacing = 'log'\nstart = 0.01\nstop = 1\ncount = 5",
        "axes = [{parameter = 'h1', values = [0.1, 0.7]}, {parameter = 'b', start = 1, stop = 2, count = 3}, \
         {parameter = 'x0', values = [0.0, 1.0]}]",
        "points = {columns = ['h1', 'zeta_k'], rows = [[0.1, 3.0], [0.2, 4.5]]}",
    ] {
        let experiment = Request::from_toml(toml).unwrap().resolve().unwrap();
        let again = Request::from_toml(&experiment.to_toml()).unwrap().resolve().unwrap();
        assert_eq!(experiment, again, "{toml}");
    }
    let points = "points = {columns = ['h1', 'zeta_k'], rows = [[0.1, 3.0], [0.2, 4.5]]}";
    let design = Request::from_toml(points).unwrap().resolve().unwrap().design;
    assert_eq!((design.len(), design.point(1)[Parameter::ZetaK]), (2, 4.5));
}
