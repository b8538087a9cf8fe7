//! Ticks and numbers for axes, colour bars and captions.
//!
//! Owns how numbers are written; draws nothing.

use crate::machine::units::rounded;

/// A labelled value of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    pub value: f64,
    pub label: String,
}

/// Ticks in `low..=high`: multiples of 1, 2 or 5 times a power of ten, as many as possible with at most `most` steps. Ends a
/// little beyond round numbers do not change the ticks, so that nearly equal axes have equal ticks.
pub fn ticks(low: f64, high: f64, most: usize) -> Vec<Tick> {
    let most = most.max(1);
    let ends = |step: f64| {
        // A tick at an end must not be lost to rounding.
        let first = (low / step - 1e-6).ceil() as i64;
        let last = (high / step + 1e-6).floor() as i64;
        (first, last)
    };
    let coarse = round_step((high - low) / most as f64);
    let fine = round_step((high - low) / (most + 1) as f64);
    let (first, last) = ends(fine);
    let step = if last - first <= most as i64 { fine } else { coarse };
    let (first, last) = ends(step);
    let largest = low.abs().max(high.abs());
    (first..=last)
        .map(|k| {
            let value = k as f64 * step;
            Tick {
                value,
                label: label(value, step, largest),
            }
        })
        .collect()
}

/// Ticks of a logarithmic axis between two decadic logarithms: powers of ten. If there are few of them, also 2 and 5 times these
/// powers; if there are still fewer, round numbers at equal distances instead.
pub fn decades(low: f64, high: f64) -> Vec<Tick> {
    // an end that is a power of ten must not be lost to rounding
    let slack = 1e-9 * (high - low);
    let (low, high) = (low - slack, high + slack);
    let factors: &[f64] = if high - low > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let powers = low.floor() as i32..=high.ceil() as i32;
    let of_decades: Vec<Tick> = powers
        .flat_map(|power| factors.iter().map(move |factor| (power, *factor)))
        .map(|(power, factor)| Tick {
            value: f64::from(power) + factor.log10(),
            label: number(rounded(factor * 10f64.powi(power))),
        })
        .filter(|tick| (low..=high).contains(&tick.value))
        .collect();
    if of_decades.len() > 1 {
        return of_decades;
    }
    let between = ticks(10f64.powf(low), 10f64.powf(high), 5).into_iter();
    let between = between.map(|tick| Tick {
        value: tick.value.log10(),
        ..tick
    });
    between.collect()
}

/// The ticks if they fit; otherwise every second, third, ... tick from the first one on, so that they fit.
pub fn thinned(ticks: &[Tick], fits: impl Fn(&[Tick]) -> bool) -> Vec<Tick> {
    let every = |stride: usize| -> Vec<Tick> { ticks.iter().step_by(stride).cloned().collect() };
    (1..ticks.len())
        .map(every)
        .find(|ticks| fits(ticks))
        .unwrap_or_else(|| every(ticks.len().max(1)))
}

/// The least of 1, 2, 5 times a power of ten that is `least` or more.
pub fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|factor| factor * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// The least number that is `least` or more from a finer series of round numbers, for the limits of a scale.
pub fn round_up(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let factors = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];
    let factor = factors
        .into_iter()
        .find(|factor| factor * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// `value` with the digits that a scale with ticks every `step` and values up to `largest` needs.
fn label(value: f64, step: f64, largest: f64) -> String {
    let exponent = largest.log10().floor() as i32;
    let digits = |step: f64| (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
    if value == 0.0 || is_plain(exponent) {
        return with_minus(&format!("{value:.*}", digits(step)));
    }
    let power = 10f64.powi(exponent);
    let mantissa = with_minus(&format!("{:.*}", digits(step / power), value / power));
    format!("{mantissa}×10{}", superscript(exponent))
}

/// A number with all the digits that it has.
pub fn number(value: f64) -> String {
    let exponent = if value == 0.0 {
        0
    } else {
        value.abs().log10().floor() as i32
    };
    if is_plain(exponent) || !value.is_finite() {
        return with_minus(&value.to_string());
    }
    let text = format!("{value:e}");
    let (mantissa, exponent) = text.split_once('e').expect("the format writes an exponent");
    let power = format!(
        "10{}",
        superscript(exponent.parse().expect("the format writes a number"))
    );
    let mantissa = with_minus(mantissa);
    if mantissa == "1" {
        power
    } else {
        format!("{mantissa}×{power}")
    }
}

/// Whether numbers of this magnitude are written without a power of ten.
fn is_plain(exponent: i32) -> bool {
    (-4..6).contains(&exponent)
}

fn with_minus(text: &str) -> String {
    let is_zero = text.chars().all(|character| "-0.".contains(character));
    text.replace('-', if is_zero { "" } else { "\u{2212}" })
}

fn superscript(exponent: i32) -> String {
    let glyph = |character| match character {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit.to_digit(10).expect("a digit")).expect("a superscript digit"),
    };
    exponent.to_string().chars().map(glyph).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, most: usize) -> Vec<String> {
        ticks(low, high, most).into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn decades_are_powers_of_ten_and_parts_of_few() {
        let labels = |low, high| {
            decades(low, high)
                .into_iter()
                .map(|tick| tick.label)
                .collect::<Vec<_>>()
        };
        assert_eq!(labels(-3.1, 0.1), ["0.001", "0.01", "0.1", "1"]);
        assert_eq!(labels(-1.1, 0.1), ["0.1", "0.2", "0.5", "1"]);
        assert_eq!(decades(-1.0, 0.0)[1].value, 0.2f64.log10());
        assert_eq!(
            labels(3f64.log10(), 4f64.log10()),
            ["3.0", "3.2", "3.4", "3.6", "3.8", "4.0"]
        );
    }

    #[test]
    fn ticks_that_do_not_fit_are_thinned_evenly() {
        let all = ticks(0.0, 10.0, 10);
        let labels = |most: usize| -> Vec<String> {
            let fits = |ticks: &[Tick]| ticks.len() <= most;
            thinned(&all, fits).into_iter().map(|tick| tick.label).collect()
        };
        assert_eq!(labels(11).len(), 11);
        assert_eq!(labels(6), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(5), ["0", "3", "6", "9"]);
        assert_eq!(labels(1), ["0"]);
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(labels(0.0, 12.0, 8), ["0", "2", "4", "6", "8", "10", "12"]);
        assert_eq!(labels(-0.02, 2.02, 6), ["0.0", "0.5", "1.0", "1.5", "2.0"]);
        assert_eq!(
            labels(-0.3, 0.3, 6),
            ["−0.3", "−0.2", "−0.1", "0.0", "0.1", "0.2", "0.3"]
        );
        assert_eq!(
            labels(1e-6, 5e-6, 4),
            ["1×10⁻⁶", "2×10⁻⁶", "3×10⁻⁶", "4×10⁻⁶", "5×10⁻⁶"]
        );
        assert_eq!(labels(3.000, 3.001, 3), ["3.0000", "3.0005", "3.0010"]);
        assert_eq!(labels(-2e6, 0.0, 2), ["−2×10⁶", "−1×10⁶", "0"]);
        // an axis that is half a point longer at either end
        assert_eq!(labels(3.5, 4.0, 10), labels(3.4998, 4.0002, 10));
        for (low, high) in [(0.1, 0.7), (-1e-9, 1e-9), (1.0, 1000.0), (0.37, 0.3701), (-7.0, 123.4)] {
            for most in 1..12 {
                let ticks = ticks(low, high, most);
                assert!(ticks.len() <= most + 1, "{low} {high} {most}: {ticks:?}");
                let slack = (high - low) * 1e-5;
                assert!(
                    ticks
                        .iter()
                        .all(|tick| (low - slack..=high + slack).contains(&tick.value))
                );
            }
            assert!(ticks(low, high, 5).len() >= 2);
        }
    }

    #[test]
    fn numbers_keep_their_digits() {
        for (value, text) in [
            (2.0, "2"),
            (-0.25, "−0.25"),
            (0.0, "0"),
            (0.01, "0.01"),
            (1e-6, "10⁻⁶"),
            (-2.5e-12, "−2.5×10⁻¹²"),
            (1.0 / 3.0, "0.3333333333333333"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn limits_are_rounded_up() {
        for (value, limit) in [(0.231, 0.25), (0.25, 0.25), (0.91, 1.0), (1.1, 1.2), (30.0, 30.0)] {
            assert!(
                (round_up(value) / limit - 1.0).abs() < 1e-12,
                "{value}: {}",
                round_up(value)
            );
        }
    }
}
