//! The heat conduction of the shaft as a few decaying modes: roots, weights, and one lumped mode for all the rest.
//!
//! Owns the shaft's spectrum; knows neither friction nor motion, and integrates nothing. Plain f64 on the host, without
//! a twin: the backends are given these numbers.
//!
//! With the heat source Q(tau) = F(v) v p and modes q_m' = -mu_m^2 w q_m + Q, q_m(0) = 0, where w is omega-tilde and g is gamma,
//!
//! ```text
//! thermal part of the pressure  2 g (sum_{m<=M} c_m q_m + c_t q_t)
//! temperature                   theta(r) = g (sum_{m<=M} d_m(r) q_m + kappa_q(r) q_t + (kappa_Q(r)/w) Q)
//! lumped mode                   q_t' = -l w q_t + Q
//! ```
//!
//! Without the lumped mode and with M = infinity this is exact (equations (2.2), (2.4) and (2.5)).

use std::f64::consts::PI;

/// Number of roots in a tail that are summed one by one. The rest of the tail is computed as an integral.
const EXPLICIT_TAIL: usize = 300;

/// The first `count` positive roots mu_m of Bi J0(mu) = mu J1(mu), in rising order, to a few units of the last place.
///
/// One lies in each interval between a zero of J1 (0 included) and the next zero of J0. `biot` from 1e-4 to 1e4 is
/// tested. Source: equation (2.5); H. S. Carslaw and J. C. Jaeger, Conduction of Heat in Solids, 2nd ed., section 7.7.
///
/// # Panics
/// If `biot` is not positive and finite.
#[must_use]
pub fn roots(biot: f64, count: usize) -> Vec<f64> {
    assert!(biot > 0.0 && biot.is_finite(), "a Biot number of {biot}");
    (1..=count).map(|m| root(biot, m)).collect()
}

/// The rate mu_1^2 omega-tilde at which the slowest heat mode decays.
#[must_use]
pub fn slowest_rate(biot: f64, omega_tilde: f64) -> f64 {
    root(biot, 1).powi(2) * omega_tilde
}

/// The root between the (m-1)-th zero of J1 and the m-th zero of J0, by Newton's method kept inside its bracket.
fn root(biot: f64, m: usize) -> f64 {
    let (mut low, mut high) = (if m == 1 { 0.0 } else { zero_of_j1(m - 1) }, zero_of_j0(m));
    // multiplied by this sign, the function falls through 0 at the root
    let sign = if m % 2 == 1 { 1.0 } else { -1.0 };
    // the starting value: exact in both limits of biot; for m = 1 with the right leading term for small biot
    let mut mu = if m == 1 {
        (2.0 * biot / (1.0 + biot / 2.0 + 2.0 * biot / (high * high))).sqrt()
    } else {
        low + (high - low) * biot / (biot + low)
    };
    for _ in 0..200 {
        let (j0, j1) = (libm::j0(mu), libm::j1(mu));
        let value = biot * j0 - mu * j1;
        if sign * value > 0.0 {
            low = mu;
        } else {
            high = mu;
        }
        let step = value / (biot * j1 + mu * j0);
        if step.abs() <= f64::EPSILON * mu {
            return mu + step;
        }
        mu = if low < mu + step && mu + step < high {
            mu + step
        } else {
            f64::midpoint(low, high)
        };
    }
    mu
}

/// The m-th positive zero of J0: McMahon's expansion, refined by Newton's method.
fn zero_of_j0(m: usize) -> f64 {
    let eight_b = 8.0 * PI * (m as f64 - 0.25);
    let start = eight_b / 8.0 + 1.0 / eight_b - 124.0 / (3.0 * eight_b.powi(3));
    (0..3).fold(start, |x, _| x + libm::j0(x) / libm::j1(x))
}

/// The m-th positive zero of J1: McMahon's expansion, refined by Newton's method.
fn zero_of_j1(m: usize) -> f64 {
    let eight_b = 8.0 * PI * (m as f64 + 0.25);
    let start = eight_b / 8.0 - 3.0 / eight_b + 12.0 / eight_b.powi(3);
    (0..3).fold(start, |x, _| {
        let j1 = libm::j1(x);
        x - j1 / (libm::j0(x) - j1 / x)
    })
}

/// The shaft's heat conduction, reduced to `roots.len()` modes and a lumped one, which keeps two moments of the rest.
///
/// With G the kernel of the thermal pressure, the sum of c_m exp(-mu_m^2 w tau), the lumped mode keeps three properties exactly,
/// for every M: G(0) = 1 (so that p(0) = h_U(0)); Int G = 1/(2 Bi w) (the steady pressure); and the balance of heat: d/dtau of
/// the stored heat (c . q) is Q minus w Bi theta(1)/g.
#[derive(Clone, Debug)]
pub struct ThermalModes {
    biot: f64,
    /// mu_m; mode m decays at the rate mu_m^2 w.
    pub roots: Vec<f64>,
    /// c_m = 2 Bi/(Bi^2 + mu_m^2).
    pub pressure_weights: Vec<f64>,
    /// c_t = sum of c_m over all m > M.
    pub lumped_weight: f64,
    /// l = c_t/R_M with R_M the sum of c_m/mu_m^2 over all m > M: the lumped mode decays at the rate l w.
    pub lumped_rate: f64,
    /// R_M.
    lumped_resistance: f64,
}

/// How much each mode contributes to the shaft's temperature at one radius.
#[derive(Clone, Debug, PartialEq)]
pub struct TemperatureWeights {
    /// d_m(r) = [2 mu_m^2/(Bi^2 + mu_m^2)] J0(mu_m r)/J0(mu_m), the weight of q_m.
    pub modes: Vec<f64>,
    /// kappa_q, the weight of q_t.
    pub lumped: f64,
    /// kappa_Q, the weight of Q/w; 0 at the surface.
    pub direct: f64,
}

impl ThermalModes {
    /// The first `count` modes at Biot number `biot`, and the lumped rest.
    ///
    /// The two sums over the rest are taken from their own terms: 1 - sum c_m and 1/(2 Bi) - sum c_m/mu_m^2 would lose
    /// all digits at small `biot`.
    ///
    /// # Panics
    /// If `count` is 0 or `biot` is not positive and finite.
    #[must_use]
    pub fn new(biot: f64, count: usize) -> Self {
        assert!(count > 0, "at least one thermal mode");
        let mut roots = roots(biot, count + EXPLICIT_TAIL);
        let [lumped_weight, lumped_resistance] = tails(biot, &roots[count..]);
        roots.truncate(count);
        Self {
            biot,
            pressure_weights: roots.iter().map(|mu| pressure_weight(biot, *mu)).collect(),
            roots,
            lumped_weight,
            lumped_rate: lumped_weight / lumped_resistance,
            lumped_resistance,
        }
    }

    /// The weights of the temperature at radius `r`, 0 at the axis and 1 at the surface.
    ///
    /// kappa_q = l^2 S2_M and kappa_Q = S_M - kappa_q/l give the rest of the kernel its exact zeroth and first moments. Here
    ///
    /// ```text
    /// S_M(r)  = 1/Bi - sum_{m<=M} d_m(r)/mu_m^2
    /// S2_M(r) = (1/Bi)(1/4 + 1/(2 Bi) - r^2/4) - sum_{m<=M} d_m(r)/mu_m^4
    /// ```
    ///
    /// The totals before the sums are the first two terms of the Laplace transform I0(s r)/(s I1(s) + Bi I0(s)) in powers of s^2.
    /// At the surface d_m(1) = mu_m^2 c_m/Bi, hence S_M(1) = c_t/Bi, S2_M(1) = R_M/Bi, kappa_q = l c_t/Bi, kappa_Q = 0: at the
    /// surface, the lumped mode acts as one more mode with mu^2 = l. At other radii, the sums are computed from these values.
    ///
    /// # Panics
    /// If `r` is outside 0..=1.
    #[must_use]
    pub fn temperature_weights(&self, r: f64) -> TemperatureWeights {
        assert!((0.0..=1.0).contains(&r), "a radius of {r}");
        let mut zeroth = self.lumped_weight / self.biot;
        let mut first = self.lumped_resistance / self.biot + (1.0 - r * r) / (4.0 * self.biot);
        let weight = |(mu, c): (&f64, &f64)| {
            let square = mu * mu;
            let at_surface = square * c / self.biot;
            let beyond_surface = at_surface * ((libm::j0(mu * r) - libm::j0(*mu)) / libm::j0(*mu));
            zeroth -= beyond_surface / square;
            first -= beyond_surface / (square * square);
            at_surface + beyond_surface
        };
        let modes = self.roots.iter().zip(&self.pressure_weights).map(weight).collect();
        let lumped = self.lumped_rate * self.lumped_rate * first;
        // at the surface this is 0 except for rounding
        let direct = if r < 1.0 {
            zeroth - lumped / self.lumped_rate
        } else {
            0.0
        };
        TemperatureWeights { modes, lumped, direct }
    }
}

/// c(mu) = 2 Bi/(Bi^2 + mu^2).
fn pressure_weight(biot: f64, mu: f64) -> f64 {
    2.0 * biot / (biot * biot + mu * mu)
}

/// The sums of c_m and of c_m/mu_m^2 over the consecutive `roots`, at least some hundred, and over all roots above them.
///
/// At the roots, a smooth phase Phi(mu), in which J0 and Y0 take the places of cosine and sine, is a multiple of pi. Midway in
/// phase between the last root and the next, there is a zero of Bi Y0 - mu Y1. From there on, the sum over the roots is an
/// integral over Phi/pi, by the midpoint rule of Euler and Maclaurin:
///
/// ```text
/// sum_{m>N} f(mu_m) = Int f dPhi/pi + (1/24) df/d(Phi/pi) - ...   at Phi = (N + 1/2) pi
/// dPhi/dmu = (Bi^2 + mu^2)/D(mu)
/// D = (pi mu/2) ((Bi J0 - mu J1)^2 + (Bi Y0 - mu Y1)^2)
///   ~ mu^2 + Bi^2 - Bi + 3/8 + (3 Bi/8 - Bi^2/8 - 45/128)/mu^2
/// ```
///
/// (from the Wronskian and the expansions of J^2 + Y^2, Abramowitz and Stegun 9.1.16 and 9.2.28). At mu > 900 the omitted terms
/// are below 1e-11 of the sums.
fn tails(biot: f64, roots: &[f64]) -> [f64; 2] {
    let squares = biot * biot;
    let last = roots.last().expect("roots to start the tail from");
    let midway = (0..4).fold(last + PI / 2.0, |mu, _| {
        let (y0, y1) = (libm::y0(mu), libm::y1(mu));
        mu + (biot * y0 - mu * y1) / (biot * y1 + mu * y0)
    });
    let constant = squares - biot + 3.0 / 8.0;
    let falling = 3.0 * biot / 8.0 - squares / 8.0 - 45.0 / 128.0;

    // from the smallest terms to the largest; in t = 1/mu the integrands are 1 and t^2 times 2 Bi/(pi t^2 D)
    let mut sums = [0.0; 2];
    let mut upper = 1.0 / midway;
    let mut panels = vec![upper];
    // the integrand changes at t of about 1/Bi: panels of equal ratio resolve it wherever it lies
    while upper * (biot + 1.0) > 0.25 {
        upper /= 2.0;
        panels.push(upper);
    }
    panels.push(0.0);
    for panel in panels.windows(2).rev() {
        let (high, low) = (panel[0], panel[1]);
        for (node, weight) in GAUSS {
            for t in [node, -node].map(|node| f64::midpoint(low, high) + (high - low) / 2.0 * node) {
                let t2 = t * t;
                let density = 2.0 * biot / (PI * (1.0 + t2 * (constant + t2 * falling)));
                let integral = weight * (high - low) / 2.0 * density;
                sums[0] += integral;
                sums[1] += integral * t2;
            }
        }
    }
    let mu2 = midway * midway;
    let spacing = PI * (mu2 + constant + falling / mu2) / (squares + mu2);
    let f = pressure_weight(biot, midway);
    let slope = -2.0 * midway * f / (squares + mu2) * spacing;
    sums[0] += slope / 24.0;
    sums[1] += (slope / mu2 - 2.0 * f / (mu2 * midway) * spacing) / 24.0;

    for mu in roots.iter().rev() {
        let c = pressure_weight(biot, *mu);
        sums[0] += c;
        sums[1] += c / (mu * mu);
    }
    sums
}

/// Nodes and weights of the Gauss-Legendre rule with 8 points on -1..1; the other 4 nodes are the negatives.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Biot number, its roots 1, 2, 8, 12 and 60, and (M, c_t, R_M): from direct summation with 40 digits.
    type Reference = (f64, [f64; 5], [(usize, f64, f64); 3]);

    const REFERENCES: [Reference; 6] = [
        (
            1e-4,
            [
                0.014141958848877083,
                3.8317320681545373,
                22.76008877424917,
                35.3323103803546,
                186.1373506465332,
            ],
            [
                (1, 2.4999791658854e-5, 1.0416406248698e-6),
                (8, 2.6122272134835e-6, 1.4604169421896e-9),
                (12, 1.7238928136167e-6, 4.2064443106558e-10),
            ],
        ),
        (
            1e-2,
            [
                0.1412447637298254,
                3.8343148797097055,
                22.76052374200594,
                35.332590576027386,
                186.1374038330567,
            ],
            [
                (1, 0.002497908881078, 0.00010390612203008),
                (8, 0.00026121981517808, 1.4603589069053e-7),
                (12, 0.00017238844428698, 4.2063711362024e-8),
            ],
        ),
        (
            1.0,
            [
                1.2557837117945936,
                4.079477710797353,
                22.80395051863161,
                35.36059139326456,
                186.14272235698604,
            ],
            [
                (1, 0.22390157485138, 0.0078617611948831),
                (8, 0.02607860328787, 1.4531430981656e-5),
                (12, 0.017226327429077, 4.1972484367009e-6),
            ],
        ),
        (
            10.0,
            [
                2.1794965966644577,
                5.033211975699267,
                23.170957118928744,
                35.60713182212069,
                186.1910145673804,
            ],
            [
                (1, 0.80906958682526, 0.0098058617471634),
                (8, 0.24561236722692, 0.00012832372243841),
                (12, 0.16760194972784, 3.9649405942415e-5),
            ],
        ),
        (
            1e2,
            [
                2.3809016634910467,
                5.465207002239944,
                24.114699321587615,
                36.564933483388295,
                186.62984050657175,
            ],
            [
                (1, 0.98001133096229, 0.0014738485598902),
                (8, 0.84347792886086, 0.00016500431109281),
                (12, 0.77091529190548, 9.0719209082339e-5),
            ],
        ),
        (
            1e4,
            [
                2.404585087168365,
                5.5195261301308065,
                24.350036410167327,
                36.913406845174784,
                187.6920590195452,
            ],
            [
                (1, 0.99980000001156, 1.5410070899537e-5),
                (8, 0.99840000368456, 2.4434824027228e-6),
                (12, 0.99760001207888, 1.6435678476264e-6),
            ],
        ),
    ];

    fn relative(value: f64, expected: f64) -> f64 {
        (value / expected - 1.0).abs()
    }

    /// Int_0^1 f(r) r dr, for f that oscillates slower than J0(100 r).
    fn mean(f: impl Fn(f64) -> f64) -> f64 {
        let panels = 64;
        let half = 0.5 / f64::from(panels);
        (0..panels)
            .flat_map(|panel| {
                GAUSS
                    .into_iter()
                    .flat_map(move |(x, w)| [(panel, x, w), (panel, -x, w)])
            })
            .map(|(panel, node, weight)| {
                let r = half * (f64::from(2 * panel + 1) + node);
                weight * half * r * f(r)
            })
            .sum()
    }

    #[test]
    fn roots_and_rests_are_those_of_forty_digit_arithmetic() {
        for (biot, expected, rests) in REFERENCES {
            let found = roots(biot, 60);
            for (m, root) in [1, 2, 8, 12, 60].into_iter().zip(expected) {
                assert!(relative(found[m - 1], root) < 5e-16, "{biot}: {} {root}", found[m - 1]);
            }
            for (count, weight, resistance) in rests {
                let modes = ThermalModes::new(biot, count);
                assert!(
                    relative(modes.lumped_weight, weight) < 1e-11,
                    "{biot} {count} {modes:?}"
                );
                let off = relative(modes.lumped_resistance, resistance);
                assert!(off < 1e-11, "{biot} {count}: {off:e}");
                assert!(relative(modes.lumped_rate, weight / resistance) < 2e-11);
            }
        }
    }

    #[test]
    fn roots_are_those_of_carslaw_and_jaeger_s_table() {
        // table III of the appendix, four decimals
        assert!((roots(1.0, 1)[0] - 1.2558).abs() < 5e-5);
        let ten = roots(10.0, 5);
        for (root, expected) in ten.iter().zip([2.1795, 5.0332, 7.9569, 10.9363, 13.9580]) {
            assert!((root - expected).abs() < 5e-5, "{root}");
        }
    }

    #[test]
    fn there_is_one_root_between_each_zero_of_j1_and_the_next_of_j0() {
        for exponent in -16..=16 {
            let biot = 10f64.powf(f64::from(exponent) / 4.0);
            let roots = roots(biot, 400);
            assert_eq!(roots.len(), 400);
            for (index, mu) in roots.iter().enumerate() {
                let low = if index == 0 { 0.0 } else { zero_of_j1(index) };
                assert!(low < *mu && *mu < zero_of_j0(index + 1), "{biot} {index}");
                // the root's error in units of its last place, by the function's slope
                let (j0, j1) = (libm::j0(*mu), libm::j1(*mu));
                let off = (biot * j0 - mu * j1) / (biot * j1 + mu * j0);
                assert!(off.abs() < 4.0 * f64::EPSILON * mu, "{biot} {index}: {off:e}");
            }
        }
        assert!(roots(1.0, 0).is_empty());
    }

    #[test]
    fn weights_and_rests_add_up_to_the_known_totals() {
        for (biot, ..) in REFERENCES {
            for count in [1, 8, 12, 24, 64] {
                let modes = ThermalModes::new(biot, count);
                let sum = |term: &dyn Fn(f64, f64) -> f64| -> f64 {
                    let terms = modes.roots.iter().zip(&modes.pressure_weights);
                    terms.map(|(mu, c)| term(*mu, *c)).sum()
                };
                assert!(relative(sum(&|_, c| c) + modes.lumped_weight, 1.0) < 1e-12);
                let resistance = sum(&|mu, c| c / (mu * mu)) + modes.lumped_resistance;
                assert!(relative(resistance, 0.5 / biot) < 1e-12);

                let surface = modes.temperature_weights(1.0);
                let steady: f64 = modes
                    .roots
                    .iter()
                    .zip(&surface.modes)
                    .map(|(mu, d)| d / (mu * mu))
                    .sum();
                let steady = steady + surface.lumped / modes.lumped_rate;
                assert!(relative(steady, 1.0 / biot) < 1e-12, "{biot} {count}");
                assert!(relative(surface.lumped, modes.lumped_rate * modes.lumped_weight / biot) < 1e-12);
            }
        }
    }

    #[test]
    fn the_mean_temperature_is_the_heat_in_the_shaft() {
        for (biot, ..) in REFERENCES {
            let modes = ThermalModes::new(biot, 12);
            for (m, c) in modes.pressure_weights.iter().enumerate() {
                let stored = mean(|r| modes.temperature_weights(r).modes[m]);
                assert!((stored - c).abs() < 1e-12, "{biot} {m}: {stored} {c}");
            }
            // the steady part of the rest
            let rest = |r| {
                let weights = modes.temperature_weights(r);
                weights.lumped / modes.lumped_rate + weights.direct
            };
            assert!((mean(rest) - modes.lumped_resistance).abs() < 1e-12, "{biot}");
        }
    }

    #[test]
    fn a_steady_source_gives_the_steady_temperature_everywhere() {
        // theta = g/(Bi w), the same at all radii
        for (biot, ..) in REFERENCES {
            let modes = ThermalModes::new(biot, 8);
            for r in [0.0, 0.3, 0.9, 0.999, 1.0] {
                let weights = modes.temperature_weights(r);
                let sum: f64 = modes
                    .roots
                    .iter()
                    .zip(&weights.modes)
                    .map(|(mu, d)| d / (mu * mu))
                    .sum();
                let steady = sum + weights.lumped / modes.lumped_rate + weights.direct;
                assert!(relative(steady, 1.0 / biot) < 1e-12, "{biot} {r}");
            }
        }
    }

    #[test]
    fn the_reconstructed_preset_has_these_rates() {
        let modes = ThermalModes::new(10.0, 8);
        assert!((0.1 * modes.lumped_rate - 191.4).abs() < 0.01);
        assert!((0.1 * modes.roots[0].powi(2) - 0.475).abs() < 1e-4);
    }
}
