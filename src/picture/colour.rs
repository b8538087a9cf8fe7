//! Colours: scales that are uniform to the eye, and the fixed colours of kinds of motion.
//!
//! Owns every colour of the pictures but black and white lines; knows neither maps nor figures.

use palette::{FromColor, Oklab, Oklch, Srgb};

use crate::measure::Class;

/// Red, green and blue, encoded as sRGB.
pub type Rgb = [u8; 3];

/// A pair of colour scales: a two-sided one for quantities with a meaningful zero, a sequential one for the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourScale {
    /// Two-sided: blue below zero, red above. Sequential: yellow to blue.
    #[default]
    BlueRed,
    /// Two-sided: purple below zero, green above. Sequential: pale green to purple.
    PurpleGreen,
}

/// Lightness at zero and at the limits of a two-sided scale.
const TWO_SIDED_LIGHTNESS: (f32, f32) = (0.97, 0.42);
/// Lightness at the lower and the upper limit of a sequential scale.
const SEQUENTIAL_LIGHTNESS: (f32, f32) = (0.94, 0.30);

impl ColourScale {
    /// All pairs, the default first.
    pub const ALL: [Self; 2] = [Self::BlueRed, Self::PurpleGreen];

    /// The name by which users choose it.
    pub fn name(self) -> &'static str {
        match self {
            Self::BlueRed => "blue-red",
            Self::PurpleGreen => "purple-green",
        }
    }

    /// Finds a pair by what [`ColourScale::name`] gives.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scale| scale.name() == name)
    }

    /// The colour of `t`: -1 is the lower limit, 1 the upper limit. Beyond a limit, the colour is that of the limit.
    ///
    /// Either side is a straight line in Oklab, so equal differences of `t` look equally large, and both sides have the
    /// same lightness at the same distance from zero.
    pub fn two_sided(self, t: f64) -> Rgb {
        let (below, above, chroma) = match self {
            Self::BlueRed => (262.0, 29.0, 0.16),
            Self::PurpleGreen => (310.0, 145.0, 0.125),
        };
        let distance = t.abs().min(1.0) as f32;
        let hue = if t < 0.0 { below } else { above };
        oklch(between(TWO_SIDED_LIGHTNESS, distance), chroma * distance, hue)
    }

    /// The colour of `t`: 0 is the lower limit, 1 the upper limit. Beyond a limit, the colour is that of the limit. Lightness
    /// falls in proportion to `t`.
    pub fn sequential(self, t: f64) -> Rgb {
        let t = t.clamp(0.0, 1.0) as f32;
        let lightness = between(SEQUENTIAL_LIGHTNESS, t);
        let hues = match self {
            Self::BlueRed => (105.0, 275.0),
            Self::PurpleGreen => (145.0, 320.0),
        };
        oklch(lightness, 0.085, between(hues, t))
    }
}

fn between(ends: (f32, f32), t: f32) -> f32 {
    ends.0 + (ends.1 - ends.0) * t
}

fn oklch(lightness: f32, chroma: f32, hue: f32) -> Rgb {
    let colour = Oklab::from_color(Oklch::new(lightness, chroma, hue));
    Srgb::from_color(colour).into_format::<u8>().into()
}

// Colours of kinds of motion. They are clearly different; most pairs are so also for readers who cannot tell red from green.
/// Grey.
pub const UNDECIDED: Rgb = [0x8c, 0x8c, 0x8c];
/// Yellow.
pub const QUASI_PERIODIC: Rgb = [0xff, 0xe9, 0x3b];
/// Brown.
pub const UNSTABLE: Rgb = [0x6b, 0x3e, 0x12];
/// Black.
pub const RUNAWAY: Rgb = [0, 0, 0];
/// Magenta: a defect of the computation, to be seen at once.
pub const UNDER_RESOLVED: Rgb = [0xd6, 0x00, 0xb4];
/// Chaos in pictures without an exponent scale.
pub const CHAOTIC: Rgb = [0xe4, 0xe4, 0xe4];
/// Regular motion whose period was not found.
pub const REGULAR: Rgb = [0x00, 0xb4, 0xc8];
/// Values that do not apply to a point.
pub const NOT_APPLICABLE: Rgb = CHAOTIC;

/// The colour of a class, where no scale of exponents is shown.
pub const fn class_colour(class: Class) -> Rgb {
    match class {
        Class::Chaotic => PERIODS[4],
        Class::Regular => PERIODS[0],
        Class::QuasiPeriodic => QUASI_PERIODIC,
        Class::Undecided => UNDECIDED,
        Class::Unstable => UNSTABLE,
    }
}

/// Periods and other counts: 1 to 8, then the groups 9 to 16, 17 to 32, and longer.
pub const PERIODS: [Rgb; 11] = [
    [0x3f, 0x78, 0xc0],
    [0xef, 0x8a, 0x17],
    [0x28, 0xb4, 0x4a],
    [0x7a, 0x2c, 0xf0],
    [0xc8, 0x10, 0x2e],
    [0xff, 0x86, 0xdc],
    [0x10, 0x10, 0x80],
    [0x5c, 0x0a, 0x20],
    [0x86, 0xcc, 0x96],
    [0x2f, 0x6b, 0x52],
    [0x70, 0x38, 0x8c],
];

#[cfg(test)]
mod tests {
    use super::*;

    fn lab(colour: Rgb) -> Oklab {
        Oklab::from_color(Srgb::from(colour).into_format::<f32>())
    }

    fn distance(one: Rgb, other: Rgb) -> f32 {
        let (one, other) = (lab(one), lab(other));
        ((one.l - other.l).powi(2) + (one.a - other.a).powi(2) + (one.b - other.b).powi(2)).sqrt()
    }

    #[test]
    fn two_sided_scales_are_uniform_symmetric_and_nearly_white_at_zero() {
        for scale in ColourScale::ALL {
            assert!(scale.two_sided(0.0).iter().all(|&value| value >= 240));
            let mut steps = Vec::new();
            for k in 0..20 {
                let (t, next) = (f64::from(k) / 20.0, f64::from(k + 1) / 20.0);
                let [above, below] = [t, -t].map(|t| lab(scale.two_sided(t)).l);
                assert!((above - below).abs() < 0.01, "{scale:?} {t}");
                assert!(
                    (above - between(TWO_SIDED_LIGHTNESS, t as f32)).abs() < 0.01,
                    "{scale:?} {t}: {above}"
                );
                steps.push(distance(scale.two_sided(t), scale.two_sided(next)));
                steps.push(distance(scale.two_sided(-t), scale.two_sided(-next)));
            }
            let mean = steps.iter().sum::<f32>() / steps.len() as f32;
            assert!(
                steps.iter().all(|step| (step / mean - 1.0).abs() < 0.2),
                "{scale:?}: {steps:?}"
            );
            assert_eq!(scale.two_sided(7.0), scale.two_sided(1.0));
            assert_eq!(scale.two_sided(-7.0), scale.two_sided(-1.0));
            assert!(distance(scale.two_sided(1.0), scale.two_sided(-1.0)) > 0.2);
        }
    }

    #[test]
    fn sequential_scales_darken_in_proportion() {
        for scale in ColourScale::ALL {
            for k in 0..=20 {
                let t = f64::from(k) / 20.0;
                let lightness = lab(scale.sequential(t)).l;
                assert!(
                    (lightness - between(SEQUENTIAL_LIGHTNESS, t as f32)).abs() < 0.02,
                    "{scale:?} {t}"
                );
            }
            assert_eq!(scale.sequential(-3.0), scale.sequential(0.0));
            assert_eq!(scale.sequential(3.0), scale.sequential(1.0));
        }
    }

    #[test]
    fn kinds_are_told_apart() {
        let mut colours = PERIODS.to_vec();
        colours.extend([UNDECIDED, QUASI_PERIODIC, UNSTABLE, RUNAWAY, CHAOTIC, REGULAR]);
        for (index, &one) in colours.iter().enumerate() {
            for &other in &colours[..index] {
                assert!(
                    distance(one, other) > 0.1,
                    "{one:?} {other:?}: {}",
                    distance(one, other)
                );
            }
        }
    }

    #[test]
    fn overlays_are_told_from_the_exponents_around_them() {
        for scale in ColourScale::ALL {
            for k in -20..=20 {
                let exponent = scale.two_sided(f64::from(k) / 20.0);
                for kind in [UNDECIDED, QUASI_PERIODIC, UNSTABLE, RUNAWAY] {
                    assert!(distance(exponent, kind) > 0.07, "{scale:?} {k} {kind:?}");
                }
            }
        }
    }

    #[test]
    fn what_does_not_apply_is_told_from_the_values_around_it() {
        for scale in ColourScale::ALL {
            for k in 0..=20 {
                let value = scale.sequential(f64::from(k) / 20.0);
                assert!(distance(value, NOT_APPLICABLE) > 0.07, "{scale:?} {k}");
            }
        }
    }

    #[test]
    fn scales_are_found_by_name() {
        for scale in ColourScale::ALL {
            assert_eq!(ColourScale::from_name(scale.name()), Some(scale));
        }
        assert_eq!(ColourScale::from_name("rainbow"), None);
    }
}
