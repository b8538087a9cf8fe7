use resvg::tiny_skia::Pixmap;

use super::*;
use crate::map::ParameterMap;
use crate::measure::Quantity;
use crate::output::samples::{self, machine_experiment};
use crate::picture::colour::{self, Rgb};
use crate::picture::error::PictureError;

/// Pixels that have a colour.
fn count(pixels: &Pixmap, [red, green, blue]: Rgb) -> usize {
    pixels
        .data()
        .chunks_exact(4)
        .filter(|pixel| pixel[..3] == [red, green, blue])
        .count()
}

fn small() -> Style {
    Style {
        size: [80, 60],
        ..Style::default()
    }
}

#[test]
fn every_point_is_a_block_of_its_colour() {
    let exponents = [-1.0, -0.5, 0.5, 1.0, f64::NAN, -1.0];
    let style = Style {
        border: false,
        limits: Some((-1.0, 1.0)),
        ..small()
    };
    let map = samples::map("zeta_k=0:3:4", "h1=0:1:2", &exponents);
    let pixels = quantity_picture(&map, Quantity::Lyapunov, &style)
        .unwrap()
        .render()
        .unwrap();
    // A block of 20 x 30 pixels less what the frame covers of it.
    for value in [-0.5, 0.5] {
        let blocks = count(&pixels, style.colours.two_sided(value));
        assert!((570..=640).contains(&blocks), "{value}: {blocks}");
    }
}

#[test]
fn falling_axes_are_drawn_rising() {
    let style = Style {
        border: false,
        limits: Some((-1.0, 1.0)),
        ..small()
    };
    let rising = samples::map("zeta_k=0:1:2", "h1=0:1:2", &[-1.0, -0.5, 0.5, 1.0]);
    let falling = samples::map("zeta_k=1:0:2", "h1=1:0:2", &[1.0, 0.5, -0.5, -1.0]);
    let svg = |map| quantity_picture(map, Quantity::Lyapunov, &style).unwrap().svg;
    assert_eq!(svg(&rising), svg(&falling));
}

#[test]
fn the_border_lies_between_the_blocks_to_all_sides() {
    #[rustfmt::skip]
    let exponents = [
        -1.0, -1.0, 1.0, 1.0,
        -1.0, -1.0, -1.0, -1.0,
        -1.0, -1.0, 1.0, 1.0,
        -1.0, -1.0, 1.0, 1.0,
    ];
    let map = samples::map("zeta_k=0:3:4", "h1=0:3:4", &exponents);
    let page = quantity_picture(&map, Quantity::Lyapunov, &small()).unwrap();
    assert!(page.svg.contains(">border of chaos<") && page.svg.contains("Border of chaos: between"));
    let path = page
        .svg
        .lines()
        .find(|line| line.starts_with("<path d=\"M") && line.contains("#ffffff"))
        .unwrap();
    let place = |name: &str| {
        let image = page.svg.lines().find(|line| line.starts_with("<image")).unwrap();
        let value = image
            .split(&format!(" {name}=\""))
            .nth(1)
            .unwrap()
            .split('"')
            .next()
            .unwrap();
        value.parse::<f64>().unwrap()
    };
    // blocks are 20 x 15 pixels: the right half's lowest row is an island, as are its two upper ones
    let (left, bottom) = (place("x"), place("y") + 60.0);
    let up = |row: f64| {
        format!(
            "M{:.2} {:.2}V{:.2}",
            left + 40.0,
            bottom - 15.0 * (row + 1.0),
            bottom - 15.0 * row
        )
    };
    let across = |column: f64, row: f64| {
        let x = left + 20.0 * column;
        format!("M{x:.2} {:.2}H{:.2}", bottom - 15.0 * row, x + 20.0)
    };
    let strokes = [
        up(0.0),
        up(2.0),
        up(3.0),
        across(2.0, 1.0),
        across(2.0, 2.0),
        across(3.0, 1.0),
        across(3.0, 2.0),
    ];
    assert!(
        path.contains(&format!("d=\"{}\"", strokes.concat())),
        "{path} {strokes:?}"
    );
    let style = Style {
        border: false,
        ..small()
    };
    assert!(
        !quantity_picture(&map, Quantity::Lyapunov, &style)
            .unwrap()
            .svg
            .contains("order of chaos")
    );
}

#[test]
fn an_overlay_reaches_the_frame_where_it_ends_with_the_axes() {
    let map = samples::map("zeta_k=0:3:4", "h1=0:3:4", &[-1.0; 16]);
    let path = |points: Vec<[f64; 2]>| {
        let overlay = Some(Overlay {
            name: "theory".to_owned(),
            points,
        });
        let page = quantity_picture(&map, Quantity::Lyapunov, &Style { overlay, ..small() }).unwrap();
        let line = page.svg.lines().find(|line| line.contains("url(#map)")).unwrap();
        line.matches('L').count()
    };
    // two segments, and one more at each end; none in the middle of the map
    assert_eq!(path(vec![[1.0, 0.0], [1.5, 1.0], [2.0, 3.0]]), 4);
    assert_eq!(path(vec![[1.0, 1.0], [1.5, 1.5], [2.0, 2.0], [f64::NAN, 3.0]]), 2);
}

#[test]
fn the_legend_names_what_occurs_and_nothing_else() {
    let map = samples::map("zeta_k=0:3:4", "h1=0:1:2", &[-1.0, -0.5, 0.5, f64::NAN]);
    let svg = quantity_picture(&map, Quantity::Period, &small()).unwrap().svg;
    for present in [">3<", ">chaotic<", ">runaway<", ">not computed<"] {
        assert!(svg.contains(present), "{present}");
    }
    for absent in [">4<", "undecided", "quasi-periodic", "no period found"] {
        assert!(!svg.contains(absent), "{absent}");
    }
    let pixels = quantity_picture(&map, Quantity::Period, &small())
        .unwrap()
        .render()
        .unwrap();
    assert!(count(&pixels, colour::PERIODS[2]) > 2 * 550);
}

#[test]
fn limits_are_robust_stated_and_checked() {
    // neither the one extreme value nor strong damping makes the chaos pale
    let mut exponents = [vec![-1.5; 150], vec![0.15; 149]].concat();
    exponents.push(40.0);
    let map = samples::map("zeta_k=0:3:20", "h1=0:1:15", &exponents);
    let svg = quantity_picture(&map, Quantity::Lyapunov, &small()).unwrap().svg;
    assert!(svg.contains("≥\u{a0}0.2<") && svg.contains("≤\u{a0}−0.2<"), "{svg}");
    for limits in [(1.0, 1.0), (1.0, -1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        let style = Style {
            limits: Some(limits),
            ..small()
        };
        assert!(
            matches!(
                quantity_picture(&map, Quantity::Lyapunov, &style),
                Err(PictureError::Limits { .. })
            ),
            "{limits:?}"
        );
    }
}

#[test]
fn every_quantity_of_every_map_can_be_drawn() {
    for exponents in [
        vec![],
        vec![f64::NAN; 6],
        vec![0.0; 6],
        vec![-1.0, 0.5, f64::NAN, 1e-300, -3e5],
    ] {
        let map = samples::map("epsilon_0=1e-6:2e-6:3", "h1=2:0:2", &exponents);
        for info in crate::measure::QUANTITIES {
            let page = quantity_picture(&map, info.quantity, &small()).unwrap();
            page.render().unwrap();
        }
    }
}

#[test]
fn maps_that_are_too_large_are_refused() {
    let message =
        |x: &str, y: &str| check_size(&samples::experiment(x, y), &Style::default()).map_err(|error| error.to_string());
    assert_eq!(message("zeta_k=0:12:16384", "h1=0:2:100"), Ok(()));
    assert!(
        message("zeta_k=0:12:16385", "h1=0:2:100")
            .unwrap_err()
            .contains("16385 x 100 points is too large")
    );
    assert!(message("zeta_k=0:12:16384", "h1=0:2:16384").is_err());
}

#[test]
fn a_machine_s_map_has_axes_and_values_in_si_units() {
    let experiment = machine_experiment("shaft_speed_amplitude=50:300:6", "interference=1e-9:5e-9:5");
    let mut map = ParameterMap::new(experiment).unwrap();
    for index in 0..30 {
        let mut measurement = samples::measurement(-1.0);
        measurement.contact.peak_pressure = 50.0;
        measurement.contact.peak_temperature = f64::from(index as u8);
        map.set(index, &measurement);
    }
    // the scale of pressure is proportional to the interference
    let (pressures, unit) = map.si_column(Quantity::PeakPressure).unwrap();
    assert_eq!(unit, "Pa");
    assert!((pressures[0] / (50.0 * 365_384.615) - 1.0).abs() < 1e-8);
    assert!((pressures[29] / pressures[0] - 5.0).abs() < 1e-12);
    // t* is 17 ms
    let (exponents, unit) = map.si_column(Quantity::Lyapunov).unwrap();
    assert!(unit == "1/s" && (exponents[0] + 59.0).abs() < 0.1, "{}", exponents[0]);
    assert!(map.si_column(Quantity::X).is_none());
    let svg = |quantity| quantity_picture(&map, quantity, &Style::default()).unwrap().svg;
    let pressure = svg(Quantity::PeakPressure);
    for words in [
        "greatest contact pressure P (MPa)",
        "Ωₐ (rad/s)",
        "U∗ (nm)",
        ">2.5<",
        "Machine with a shaft of steel of",
        "k₁\u{a0}=\u{a0}612\u{a0}kN/m²",
        "w</tspan><tspan dy=\"-2.38\">\u{a0}=\u{a0}0.010012",
    ] {
        assert!(pressure.contains(words), "{words}");
    }
    // neither an axis nor a value that changes along an axis is listed as fixed
    assert!(!pressure.contains("Ωₐ\u{a0}=") && !pressure.contains("ζₖ\u{a0}=") && !pressure.contains("ε\u{a0}="));
    assert!(svg(Quantity::PeakTemperature).contains("rise of the surface temperature, T − T₀ (K)"));
    assert!(svg(Quantity::Lyapunov).contains("Lyapunov exponent of finite time, λ₁ (1/s)"));
    // limits are in Pa, whatever the prefix
    let style = Style {
        limits: Some((0.0, 4e7)),
        ..Style::default()
    };
    let limited = quantity_picture(&map, Quantity::PeakPressure, &style).unwrap().svg;
    assert!(limited.contains("≥\u{a0}40"), "{limited}");
    assert_eq!(map.beyond_limits(), [""; 0]);
}

#[test]
fn points_beyond_the_limits_are_counted_with_its_worst_point() {
    let experiment = machine_experiment("shaft_speed_amplitude=50:300:6", "interference=1e-9:5e-9:5");
    let mut map = ParameterMap::new(experiment).unwrap();
    for index in 0..30 {
        let mut measurement = samples::measurement(-1.0);
        measurement.contact.peak_pressure = 200.0;
        measurement.contact.peak_temperature = if index == 27 { 1e4 } else { 0.0 };
        map.set(index, &measurement);
    }
    let warnings = map.beyond_limits();
    assert_eq!(warnings.len(), 2);
    assert!(
        warnings[0].starts_with(
            "beyond the model's limits at 1 points (3.3 %): at shaft_speed_amplitude = 200 rad/s, interference = 5 nm"
        ),
        "{warnings:?}"
    );
    // 219 MPa at 3 nm are above 205 MPa
    assert!(
        warnings[1].starts_with("beyond the model's limits at 18 points (60.0 %)"),
        "{warnings:?}"
    );
    assert!(
        warnings[1].contains("365.38 MPa, and the shaft yields at 205 MPa"),
        "{warnings:?}"
    );
    let caption = paragraphs::of(&map).join(" ");
    assert!(
        caption.contains(
            "the shaft hotter than its melting point at 3.3\u{a0}% of the points, the shaft pressed beyond its yield strength at 60\u{a0}%"
        ),
        "{caption}"
    );
}
