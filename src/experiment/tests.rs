use super::*;

#[test]
fn an_experiment_survives_its_toml_form() {
    let mut request = Request::default();
    request.set.insert("omega_0".into(), 1.0 / 3.0);
    request.settings.adapter = Some("llvmpipe".into());
    let experiment = request.resolve().unwrap();
    let again = Request::from_toml(&experiment.to_toml()).unwrap().resolve().unwrap();
    assert_eq!(again, experiment);
}

#[test]
fn the_default_number_of_steps_is_the_scheme_s() {
    let mut request = Request::default();
    let steps = |request: &Request| {
        let settings = request.resolve().unwrap().settings;
        (settings.scheme.unwrap(), settings.steps_per_period.unwrap())
    };
    assert_eq!(
        steps(&request),
        (Scheme::Taylor, Scheme::Taylor.default_steps_per_period())
    );
    request.settings.scheme = Some(Scheme::Rk4);
    assert_eq!(steps(&request), (Scheme::Rk4, 628));
    request.settings.steps_per_period = Some(100);
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

#[test]
fn bad_requests_are_refused_with_a_reason() {
    for (toml, reason) in [
        ("stepz = 3", "unknown field"),
        ("[settings]\nsteps = 3", "unknown field"),
        ("[set]\nzetak = 3", "did you mean `zeta_k`"),
        ("[set]\nzeta_k = 3", "leave one of the two out"),
        ("[set]\nb = nan", "out of range"),
        ("[settings]\nsteps_per_period = 7", "from 8"),
        ("[settings]\nperiods = 0", "from 16"),
        ("[settings]\nalign_periods = 500", "from 0 to 300"),
        ("[settings]\nbackend = \"gpu\"\nprecision = \"f64\"", "f32"),
        ("[settings]\nbackend = \"gpu\"\n[set]\nepsilon_0 = 1e-5", "too thin"),
        ("[settings]\nscheme = \"euler\"", "rk4"),
        (
            "[y]\nparameter = \"zeta_k\"\nstart = 0\nstop = 1\ncount = 5",
            "different parameters",
        ),
        ("[settings.initial_box]\nx = [1, -1]\ny = [0, 1]", "lower end first"),
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
    request.settings.scheme = Some(Scheme::Rk4);
    assert!(request.resolve().unwrap().warnings().is_empty());
    request.set.insert("epsilon_0".into(), 1e-5);
    let warnings = request.resolve().unwrap().warnings();
    assert!(warnings[0].contains("--steps-per-period"));
    assert!(warnings[1].contains("--renormalise-every"));
    request.settings.scheme = None;
    assert!(request.resolve().unwrap().warnings().is_empty());
}
