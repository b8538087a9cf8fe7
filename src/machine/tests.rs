use std::f64::consts::TAU;

use super::*;
use SiQuantity as Q;

fn template() -> Machine {
    let machine = Description::from_toml(TEMPLATE).unwrap().complete(&[]).unwrap();
    machine.check().unwrap();
    machine
}

fn changed(changes: &[(Q, f64)]) -> Machine {
    changes
        .iter()
        .fold(template(), |machine, &(quantity, value)| machine.with(quantity, value))
}

/// A machine of which no quantity is zero or one.
fn generic() -> Machine {
    changed(&[
        (Q::TangentStiffness, 1.7e5),
        (Q::WearEnergyShare, 0.2),
        (Q::SpringFreeLength, 0.04),
    ])
}

fn of(machine: &Machine) -> ParameterSet {
    machine.parameters(&ParameterSet::default())
}

#[test]
fn the_example_in_si_is_the_paper_s_preset_to_three_digits() {
    let parameters = of(&template());
    for (parameter, expected) in [
        (Parameter::ZetaK, 3.9),
        (Parameter::H1, 0.5),
        (Parameter::Omega0, 2.0),
        (Parameter::OmegaK, 0.4),
        (Parameter::B, 1.0),
        (Parameter::Epsilon, 0.1),
        (Parameter::F0, 0.3),
        (Parameter::Alpha, 0.3),
        (Parameter::Beta, 0.3),
        (Parameter::Gamma, 1.868),
        (Parameter::KW, 0.01),
        (Parameter::Biot, 10.0),
        (Parameter::OmegaTilde, 0.1),
    ] {
        let value = parameters[parameter];
        assert!(
            (value / expected - 1.0).abs() < 3e-3,
            "{parameter} = {value}, not {expected}"
        );
    }
    let scales = template().scales();
    assert!((scales.time / 0.01695 - 1.0).abs() < 1e-3, "{scales:?}");
    // P* = E1 U*/((1 + nu1)(1 - 2 nu1) R1), T* = U*/(alpha1 (1 + nu1) R1)
    assert!((scales.pressure / 365_384.6 - 1.0).abs() < 1e-6, "{scales:?}");
    assert!((scales.temperature / 0.054_945_05 - 1.0).abs() < 1e-6, "{scales:?}");
    assert_eq!(scales.length, 1e-9);
}

#[test]
fn the_groups_are_those_of_the_formulas_as_the_paper_writes_them() {
    let machine = generic();
    let value = |quantity| machine.value(quantity);
    let (r1, r2, u) = (value(Q::ShaftRadius), value(Q::BushRadius), value(Q::Interference));
    let (alpha, nu, young) = (
        value(Q::ThermalExpansion),
        value(Q::PoissonsRatio),
        value(Q::YoungsModulus),
    );
    let (conductivity, diffusivity) = (value(Q::ThermalConductivity), value(Q::ThermalDiffusivity));
    let time = (value(Q::Inertia) / (machine.spring() * r2 * r2)).sqrt();
    let temperature = u / (alpha * (1.0 + nu) * r1);
    let pressure = alpha * young * temperature / (1.0 - 2.0 * nu);
    let epsilon = TAU * r1 * r1 * pressure * time * time / value(Q::Inertia);
    let h = value(Q::Damping) * r2 * r2 * time / (2.0 * value(Q::Inertia));
    let gamma = (1.0 - value(Q::WearEnergyShare)) * young * alpha * r1 * r1 / (conductivity * (1.0 - 2.0 * nu) * time);
    let parameters = of(&machine);
    for (parameter, expected) in [
        (Parameter::Epsilon, epsilon),
        (Parameter::H1, 2.0 * h / epsilon),
        (Parameter::KW, pressure * value(Q::WearCoefficient) * r1 / u),
        (Parameter::OmegaTilde, time * diffusivity / (r1 * r1)),
        // the paper's gamma times its omega-tilde
        (Parameter::Gamma, gamma * time * diffusivity / (r1 * r1)),
        (Parameter::Biot, value(Q::HeatTransfer) * r1 / conductivity),
        (Parameter::Beta, value(Q::FrictionCubic) * (r1 / time).powi(3)),
    ] {
        let value = parameters[parameter];
        assert!(
            (value / expected - 1.0).abs() < 1e-12,
            "{parameter} = {value}, not {expected}"
        );
    }
    assert!((machine.scales().pressure / pressure - 1.0).abs() < 1e-12);
}

/// The restoring moment per contact length at an angle, by elementary geometry: a radial spring between an anchor at R2 + l1 and
/// the bush's edge, and tangent springs that pull with k2 s + k3 s^3 along s = R2 sin phi, at R2 cos phi.
fn moment(machine: &Machine, phi: f64) -> f64 {
    let value = |quantity| machine.value(quantity);
    let (r2, l0, l1) = (value(Q::BushRadius), value(Q::SpringFreeLength), value(Q::SpringLength));
    let (edge, anchor) = ([r2 * phi.cos(), r2 * phi.sin()], [r2 + l1, 0.0]);
    let along = [anchor[0] - edge[0], anchor[1] - edge[1]];
    let length = along[0].hypot(along[1]);
    let pull = value(Q::RadialStiffness) * (length - l0) / length;
    let force = along.map(|component| pull * component);
    let radial = -(edge[0] * force[1] - edge[1] * force[0]);
    let s = r2 * phi.sin();
    let tangent = value(Q::TangentStiffness) * s + value(Q::TangentCubicStiffness) * s.powi(3);
    radial + r2 * phi.cos() * tangent
}

#[test]
fn k_star_and_b_are_the_coefficients_of_the_springs_geometry() {
    let machines = [
        template(),
        generic(),
        changed(&[(Q::BushRadius, 0.03), (Q::TangentStiffness, 2e4)]),
        changed(&[(Q::SpringLength, 0.004), (Q::TangentCubicStiffness, -1e9)]),
    ];
    for machine in machines {
        // m1 phi + m3 phi^3 + m5 phi^5 + m7 phi^7 through four angles
        let h: f64 = 0.01;
        let rows = nalgebra::Matrix4::from_fn(|row, column| ((row + 1) as f64 * h).powi(2 * column as i32 + 1));
        let values = nalgebra::Vector4::from_fn(|row, _| moment(&machine, (row + 1) as f64 * h));
        let m = rows.lu().solve(&values).unwrap();
        let r2 = machine.value(Q::BushRadius);
        let k_star = machine.spring();
        assert!((-m[0] / (k_star * r2 * r2) - 1.0).abs() < 1e-10, "{} {k_star}", m[0]);
        let b = of(&machine)[Parameter::B];
        let time = machine.scales().time;
        let expected = m[1] * time * time / machine.value(Q::Inertia);
        assert!((b / expected - 1.0).abs() < 1e-5, "{b} {expected}");
    }
}

#[test]
fn groups_do_not_depend_on_the_units_of_length_mass_time_and_temperature() {
    let machine = generic();
    let units: [f64; 4] = [7.3, 0.41, 2.9, 1.8];
    let in_units = |dimension: [i32; 4]| -> f64 {
        units
            .iter()
            .zip(dimension)
            .map(|(unit, exponent)| unit.powi(exponent))
            .product()
    };
    let other = SI_QUANTITIES
        .iter()
        // values per metre have the contact length 1 in any unit of length
        .filter(|info| info.quantity != Q::Length)
        .fold(machine, |changed, info| {
            changed.with(info.quantity, machine.value(info.quantity) * in_units(info.dimension))
        });
    for info in crate::parameters::PARAMETERS {
        let (before, after) = (of(&machine)[info.parameter], of(&other)[info.parameter]);
        assert!(
            before == after || (after / before - 1.0).abs() < 1e-12,
            "{}: {before} {after}",
            info.name
        );
    }
    let (before, after) = (machine.scales(), other.scales());
    for (before, after, dimension) in [
        (before.time, after.time, [0, 0, 1, 0]),
        (before.temperature, after.temperature, [0, 0, 0, 1]),
        (before.pressure, after.pressure, [-1, 1, -2, 0]),
        (before.length, after.length, [1, 0, 0, 0]),
        (before.speed, after.speed, [1, 0, -1, 0]),
    ] {
        assert!((after / (before * in_units(dimension)) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn whole_parts_over_their_length_are_the_values_per_metre() {
    let per_metre = Description::from_toml(TEMPLATE).unwrap();
    let mut whole = per_metre.clone();
    whole.values.insert(Q::Length, 0.02);
    for (quantity, value) in &mut whole.values {
        if quantity.is_extensive() {
            *value *= 0.02;
        }
    }
    let whole = whole.complete(&[]).unwrap();
    let expected = of(&template());
    for info in crate::parameters::PARAMETERS {
        let (value, expected) = (of(&whole)[info.parameter], expected[info.parameter]);
        assert!(
            value == expected || (value / expected - 1.0).abs() < 1e-12,
            "{}",
            info.name
        );
    }
    assert_eq!((whole.unit(Q::Inertia), template().unit(Q::Inertia)), ("kg m²", "kg m"));
}

#[test]
fn sensitivities_are_those_of_finite_differences_and_keep_dimensions() {
    let machine = generic();
    let table = sensitivities(&machine);
    let column = |symbol: &str| table.groups.iter().position(|group| group.symbol == symbol).unwrap();
    let entry = |quantity: Q, symbol: &str| {
        let row = table.quantities.iter().position(|other| *other == quantity).unwrap();
        table.values[row][column(symbol)]
    };
    for (row, &quantity) in table.quantities.iter().enumerate() {
        let step: f64 = 1e-5;
        let at = |factor: f64| sensitivities(&machine.with(quantity, machine.value(quantity) * factor)).groups;
        let (up, down) = (at(step.exp()), at((-step).exp()));
        for (index, value) in table.values[row].iter().enumerate() {
            let expected = (up[index].value / down[index].value).ln() / (2.0 * step);
            assert!(
                (value - expected).abs() < 1e-8,
                "{quantity} {index}: {value} {expected}"
            );
        }
    }
    // a change of the unit of length, mass, time or temperature changes no group; it changes k* as the unit of k* says
    for base in 0..4 {
        for (index, group) in table.groups.iter().enumerate().take(groups::DETERMINED + 1) {
            let rows = table.quantities.iter().zip(&table.values);
            let total: f64 = rows
                .map(|(quantity, values)| f64::from(quantity.info().dimension[base]) * values[index])
                .sum();
            let expected = if group.name == "k_star" {
                f64::from([-1, 1, -2, 0][base])
            } else {
                0.0
            };
            assert!((total - expected).abs() < 1e-12, "{group:?} {base}: {total}");
        }
    }
    for (quantity, symbol, exponent) in [
        (Q::Interference, "ε", 1.0),
        (Q::Interference, "h₁", -1.0),
        (Q::Interference, "k_w", 0.0),
        (Q::ShaftRadius, "ω̃", -2.0),
        (Q::Inertia, "t*", 0.5),
        (Q::ShaftRadius, "β", 3.0),
        (Q::FrictionCubic, "β", 1.0),
        (Q::WearEnergyShare, "γ", -0.25),
        (Q::TangentCubicStiffness, "ε", 0.0),
    ] {
        assert!(
            (entry(quantity, symbol) - exponent).abs() < 1e-12,
            "{quantity} {symbol}"
        );
    }
}

#[test]
fn what_is_proposed_to_be_changed_changes_the_parameter() {
    for info in crate::parameters::PARAMETERS {
        let determined = generic()
            .groups()
            .parameters
            .iter()
            .any(|(name, _)| *name == info.parameter);
        match governing(info.parameter) {
            Some(quantity) => assert!(determined && generic().moves(quantity, info.parameter), "{}", info.name),
            None => assert!(!determined, "{}", info.name),
        }
    }
    // the derivative is exactly 0, not only up to rounding
    for (quantity, parameter) in [
        (Q::WearCoefficient, Parameter::Gamma),
        (Q::ShaftRadius, Parameter::KW),
        (Q::Interference, Parameter::KW),
        (Q::Inertia, Parameter::Epsilon),
        (Q::Inertia, Parameter::B),
        (Q::ThermalExpansion, Parameter::H1),
    ] {
        assert!(!generic().moves(quantity, parameter), "{quantity} {parameter}");
    }
}

#[test]
fn a_description_is_read_back_as_it_was_written() {
    let mut whole = Description::from_toml(TEMPLATE).unwrap();
    whole.values.insert(Q::Length, 0.3);
    for machine in [template(), whole.complete(&[]).unwrap()] {
        let text = toml::to_string(&machine.description(&[])).unwrap();
        let again = Description::from_toml(&text).unwrap().complete(&[]).unwrap();
        assert_eq!(again, machine);
        // the value of an axis is left out, and is not needed
        let text = toml::to_string(&machine.description(&[Q::Damping])).unwrap();
        let partial = Description::from_toml(&text).unwrap();
        assert!(matches!(partial.complete(&[]), Err(MachineError::Missing { missing }) if missing == [Q::Damping]));
        assert_eq!(partial.complete(&[(Q::Damping, 778.0)]).unwrap(), machine);
    }
}

#[test]
fn bad_machines_are_refused_with_a_reason() {
    let with = |line: &str| {
        let name = line.split(' ').next().unwrap();
        let rest: Vec<&str> = TEMPLATE
            .lines()
            .filter(|other| !other.starts_with(&format!("{name} ")))
            .collect();
        format!("{line}\n{}", rest.join("\n"))
    };
    for (toml, reason) in [
        (
            String::new(),
            "lacks shaft_radius (radius of the shaft, m), bush_radius",
        ),
        (String::new(), "length_shift (contact length, m)"),
        (with("shaft_radus = 1"), "did you mean `shaft_radius`"),
        (with("gravity = 9.81"), "unknown quantity `gravity`"),
        (
            with("material = \"unobtainium\""),
            "there are paper_steel, stainless_304",
        ),
        (with("material = 3"), "expected a string"),
        (with("damping = \"weak\""), "expected f64"),
        (with("damping = -1.0"), "damping = -1 N s/m² is out of range"),
        (with("interference = nan"), "interference = NaN m is out of range"),
        (with("inertia = inf"), "inertia = inf kg m is out of range"),
        (with("wear_energy_share = 1.2"), "from 0 to 1"),
        (
            with("poissons_ratio = 0.5"),
            "poissons_ratio = 0.5 is out of range: it must be a number from -0.99 to 0.499",
        ),
        (with("spring_length = 0.0"), "out of range"),
        (
            with("spring_length = 0.032"),
            "spring_free_length = 0.03125 m must be above 0.032000 m, by 7.50e-4 m more",
        ),
        (with("tangent_stiffness = 1e6"), "k* = -8.2000e4 N/m² is not positive"),
        (
            with("bush_radius = 1e-3"),
            "shaft_radius = 0.001 m must be below bush_radius = 0.001 m",
        ),
        (
            with("interference = 2e-3"),
            "interference = 0.002 m must be below shaft_radius",
        ),
        (with("shaft_speed_frequency = 1e7"), "omega_0 = 1695"),
        (with("shaft_speed_frequency = 1e7"), "change shaft_speed_frequency"),
        (with("melting_point = -3"), "melting_point = -3 K is out of range"),
        (with("[spring]"), "spring"),
    ] {
        let result = Description::from_toml(&toml)
            .and_then(|description| description.complete(&[]))
            .and_then(|machine| machine.check());
        let message = result.unwrap_err().to_string();
        let expected = !reason.starts_with("length_shift");
        assert_eq!(message.contains(reason), expected, "{reason}: {message}");
    }
    // without a contact length there is none to vary
    let error = Description::from_toml(TEMPLATE)
        .unwrap()
        .complete(&[(Q::Length, 0.1)])
        .unwrap_err();
    assert!(error.to_string().contains("per metre of contact length"));
}

/// gamma without wear is the Grueneisen parameter, which is of order 1 for any metal: a wrong power of ten would show.
#[test]
fn every_material_makes_a_machine_with_a_grueneisen_parameter_of_a_metal() {
    for material in MATERIALS {
        let toml = TEMPLATE.replace("paper_steel", material.name);
        let machine = Description::from_toml(&toml).unwrap().complete(&[]).unwrap();
        machine.check().unwrap();
        let gamma = of(&machine)[Parameter::Gamma];
        assert!((0.5..2.5).contains(&gamma), "{}: {gamma}", material.name);
        let warnings = plausibility_warnings(&[machine]).join("\n");
        for quantity in CONSTANTS {
            assert!(!warnings.contains(quantity.name()), "{warnings}");
        }
        assert!(material.melting_point > 800.0 && material.yield_strength > 5e7 && !material.source.is_empty());
        assert_eq!(Material::from_name(material.name), Some(material));
    }
    // constants in the file replace those of the material
    let toml = TEMPLATE.replace("# youngs_modulus = 190e9", "youngs_modulus = 95e9");
    let softer = Description::from_toml(&toml).unwrap().complete(&[]).unwrap();
    assert!((of(&softer)[Parameter::Gamma] / of(&template())[Parameter::Gamma] - 0.5).abs() < 1e-12);
}

#[test]
fn no_heat_and_no_wear_are_exact() {
    let parameters = of(&changed(&[(Q::WearEnergyShare, 1.0), (Q::WearCoefficient, 0.0)]));
    assert!(!parameters.has_heat_or_wear());
}

#[test]
fn unlikely_machines_are_warned_of_and_likely_ones_are_not() {
    let warnings = plausibility_warnings(&[template()]).join("\n");
    assert!(
        warnings.contains("interference = 1 nm is 3.0 orders of magnitude below"),
        "{warnings}"
    );
    assert!(
        warnings.contains("density of 6.73e6 kg/m³, 2.5 orders of magnitude above"),
        "{warnings}"
    );
    let likely = changed(&[
        (Q::ShaftRadius, 0.02),
        (Q::BushRadius, 0.03),
        (Q::Interference, 1e-5),
        // a steel tube of these radii
        (Q::Inertia, 7800.0 * TAU / 4.0 * (0.03f64.powi(4) - 0.02f64.powi(4))),
        (Q::HeatTransfer, 1e4),
    ]);
    assert_eq!(plausibility_warnings(&[likely]), [""; 0]);
    // the warning names the worst corner
    let warnings = plausibility_warnings(&[likely, likely.with(Q::Interference, 1e-8)]);
    assert!(
        warnings.len() == 1 && warnings[0].contains("10 nm is 2.0 orders"),
        "{warnings:?}"
    );
}

#[test]
fn limits_are_passed_by_temperature_pressure_and_angle() {
    let machine = template();
    let scales = machine.scales();
    assert_eq!(machine.beyond(96.0, 543.0, 1.4), []);
    let beyond = machine.beyond(210e6 / scales.pressure, (1700.0 - 293.15) / scales.temperature, 3.2);
    assert_eq!(beyond.len(), 3);
    assert!(
        beyond[0].to_string().contains("1700 K, and the shaft melts at 1670 K"),
        "{}",
        beyond[0]
    );
    assert!(
        beyond[1]
            .to_string()
            .contains("210 MPa, and the shaft yields at 205 MPa"),
        "{}",
        beyond[1]
    );
    assert!(
        beyond[2].to_string().contains("the bush would turn by 3.2 rad"),
        "{}",
        beyond[2]
    );
    assert_eq!(machine.beyond(f64::NAN, f64::NAN, f64::NAN), []);
}

#[test]
fn an_ambient_temperature_in_celsius_or_beyond_melting_is_warned_of() {
    let warned = |ambient: f64| {
        let mut description = Description::from_toml(TEMPLATE).unwrap();
        description.ambient_temperature = Some(ambient);
        let warnings = plausibility_warnings(&[description.complete(&[]).unwrap()]);
        warnings
            .into_iter()
            .filter(|warning| warning.contains("ambient"))
            .collect::<Vec<_>>()
    };
    assert!(
        warned(20.0)[0].contains("is it in °C? Then it is 293.15 K"),
        "{:?}",
        warned(20.0)
    );
    assert!(
        warned(2000.0)[0].contains("above the melting point of the shaft, 1670 K"),
        "{:?}",
        warned(2000.0)
    );
    assert_eq!((warned(293.15), warned(400.0)), (vec![], vec![]));
}

#[test]
fn names_that_are_wrong_are_reported_with_their_line() {
    for (toml, line) in [
        (
            "shaft_radius = 1e-3\nbush_radius = 5e-3\ninterferense = 1e-9\n",
            "3 | interferense",
        ),
        (
            "shaft_radius = 1e-3\n# a comment\nmaterial = \"stele\"\n",
            "3 | material",
        ),
    ] {
        let message = Description::from_toml(toml).unwrap_err().to_string();
        assert!(message.contains("at line 3, ") && message.contains(line), "{message}");
    }
}

#[test]
fn the_contact_length_moves_nothing_but_what_it_enters() {
    let mut description = generic().description(&[]);
    description.values.insert(Q::Length, 0.3);
    let whole = description.complete(&[]).unwrap();
    let table = sensitivities(&whole);
    let row = table
        .quantities
        .iter()
        .position(|quantity| *quantity == Q::Length)
        .unwrap();
    for (group, value) in table.groups.iter().zip(&table.values[row]) {
        let enters = ["epsilon", "h1", "k_star"].contains(&group.name);
        assert_eq!(*value != 0.0, enters, "{}: {value}", group.name);
    }
}
