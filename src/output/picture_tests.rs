use super::*;
use crate::output::samples;
use resvg::tiny_skia::Pixmap;

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
        threshold: false,
        limits: Some((-1.0, 1.0)),
        ..small()
    };
    let map = samples::map("zeta_k=0:3:4", "h1=0:1:2", &exponents);
    let pixels = lyapunov_picture(&map, &style).unwrap().render().unwrap();
    // A block of 20 x 30 pixels less what the frame covers of it.
    for value in [-0.5, 0.5] {
        let blocks = count(&pixels, style.colours.two_sided(value));
        assert!((570..=640).contains(&blocks), "{value}: {blocks}");
    }
}

#[test]
fn falling_axes_are_drawn_rising() {
    let style = Style {
        threshold: false,
        limits: Some((-1.0, 1.0)),
        ..small()
    };
    let rising = samples::map("zeta_k=0:1:2", "h1=0:1:2", &[-1.0, -0.5, 0.5, 1.0]);
    let falling = samples::map("zeta_k=1:0:2", "h1=1:0:2", &[1.0, 0.5, -0.5, -1.0]);
    let svg = |map| lyapunov_picture(map, &style).unwrap().svg;
    assert_eq!(svg(&rising), svg(&falling));
}

#[test]
fn the_threshold_lies_between_the_blocks_and_breaks_where_there_is_none() {
    #[rustfmt::skip]
    let exponents = [
        -1.0, -1.0, 1.0, 1.0,
        -1.0, -1.0, -1.0, -1.0,
        -1.0, -1.0, 1.0, 1.0,
        -1.0, -1.0, 1.0, 1.0,
    ];
    let map = samples::map("zeta_k=0:3:4", "h1=0:3:4", &exponents);
    let figure = lyapunov_picture(&map, &small()).unwrap();
    assert!(figure.svg.contains("onset of chaos"));
    let path = figure
        .svg
        .lines()
        .find(|line| line.starts_with("<path d=\"M") && line.contains("#ffffff"))
        .unwrap();
    assert_eq!(path.matches('M').count(), 2, "{path}");
    // The pieces are one and two rows of 15 pixels long, at x = 1.5: two blocks of 20 pixels from the left.
    let place = |name: &str| {
        let image = figure.svg.lines().find(|line| line.starts_with("<image")).unwrap();
        let value = image
            .split(&format!(" {name}=\""))
            .nth(1)
            .unwrap()
            .split('"')
            .next()
            .unwrap();
        value.parse::<f64>().unwrap()
    };
    let (x, bottom) = (place("x") + 40.0, place("y") + 60.0);
    let start = format!(
        "d=\"M{x:.2} {bottom:.2}L{x:.2} {:.2}L{x:.2} {:.2}M",
        bottom - 7.5,
        bottom - 15.0
    );
    assert!(path.contains(&start), "{path} {start}");
    let style = Style {
        threshold: false,
        ..small()
    };
    assert!(!lyapunov_picture(&map, &style).unwrap().svg.contains("onset of chaos"));
}

#[test]
fn the_legend_names_what_occurs_and_nothing_else() {
    let map = samples::map("zeta_k=0:3:4", "h1=0:1:2", &[-1.0, -0.5, 0.5, f64::NAN]);
    let svg = period_picture(&map, &small()).unwrap().svg;
    for present in [">3<", ">chaotic<", ">runaway<", ">not computed<"] {
        assert!(svg.contains(present), "{present}");
    }
    for absent in [">4<", "undecided", "quasi-periodic", "no period found"] {
        assert!(!svg.contains(absent), "{absent}");
    }
    let pixels = period_picture(&map, &small()).unwrap().render().unwrap();
    assert!(count(&pixels, colour::PERIODS[2]) > 2 * 550);
}

#[test]
fn limits_are_robust_stated_and_checked() {
    // neither the one extreme nor strong damping pales the chaos
    let mut exponents = [vec![-1.5; 150], vec![0.15; 149]].concat();
    exponents.push(40.0);
    let map = samples::map("zeta_k=0:3:20", "h1=0:1:15", &exponents);
    let svg = lyapunov_picture(&map, &small()).unwrap().svg;
    assert!(svg.contains("≥\u{a0}0.2<") && svg.contains("≤\u{a0}−0.2<"), "{svg}");
    for limits in [(1.0, 1.0), (1.0, -1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        let style = Style {
            limits: Some(limits),
            ..small()
        };
        assert!(
            matches!(lyapunov_picture(&map, &style), Err(FigureError::Limits { .. })),
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
        for info in crate::measurement::QUANTITIES {
            let figure = quantity_picture(&map, info.quantity, &small()).unwrap();
            figure.render().unwrap();
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
