//! Radau IIA collocation with seven stages (order 13, L-stable) for the bush's motion in (x, v).
//!
//! Owns one step on one polynomial piece of the friction law, with its tangent vectors; knows of no events and no step control.
//! The sliding speed v is carried in place of y = w(tau) - v, so that nothing cancels inside a thin layer:
//!
//!     x' = w(tau) - v        w = omega_k + zeta_k sin(omega_0 tau)
//!     v' = w' - x + b x^3 - a(v) + epsilon h1 (w - v)        a(v) = epsilon F(v), a cubic on each piece
//!
//! The stages are solved by Newton's method in v alone, since x is linear in it; the tangent vectors come from the same matrix.

use std::sync::LazyLock;

/// Stages.
pub const S: usize = 7;

/// Points within a step at which the motion is looked at for events, besides its extremes.
pub const SAMPLES: usize = 12;

/// The motion's parameters, with a constant contact pressure of 1.
#[derive(Clone, Copy, Debug)]
pub struct Bush {
    pub zeta_k: f64,
    pub omega_0: f64,
    pub omega_k: f64,
    pub b: f64,
    pub epsilon: f64,
    pub h1: f64,
    pub f_0: f64,
    pub alpha: f64,
    pub beta: f64,
    pub epsilon_0: f64,
}

impl Bush {
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU / self.omega_0
    }

    /// The shaft's speed and its derivative.
    pub fn shaft(&self, tau: f64) -> [f64; 2] {
        let (sin, cos) = (self.omega_0 * tau).sin_cos();
        [self.omega_k + self.zeta_k * sin, self.zeta_k * self.omega_0 * cos]
    }

    /// epsilon F on one side of the layer: F0 sgn(side) - alpha v + beta v^3.
    pub fn sliding(&self, side: f64) -> Law {
        Law([
            side.signum() * self.epsilon * self.f_0,
            -self.epsilon * self.alpha,
            0.0,
            self.epsilon * self.beta,
        ])
    }

    /// epsilon F inside the layer, on the half of that sign.
    pub fn layer(&self, side: f64) -> Law {
        let dry = self.epsilon * self.f_0 / self.epsilon_0;
        Law([
            0.0,
            2.0 * dry - self.epsilon * self.alpha,
            -side.signum() * dry / self.epsilon_0,
            self.epsilon * self.beta,
        ])
    }

    /// v' on a piece, and its derivatives by x and by v.
    pub fn sliding_rate(&self, law: &Law, tau: f64, x: f64, v: f64) -> [f64; 3] {
        let [w, dw] = self.shaft(tau);
        self.rate_at(law, w, dw, x, v)
    }

    fn rate_at(&self, law: &Law, w: f64, dw: f64, x: f64, v: f64) -> [f64; 3] {
        let damping = self.epsilon * self.h1;
        let [a, slope] = law.at(v);
        [
            dw - x + self.b * x.powi(3) - a + damping * (w - v),
            -1.0 + 3.0 * self.b * x * x,
            -slope - damping,
        ]
    }
}

/// epsilon F(v) as a cubic: the coefficients of 1, v, v^2, v^3.
#[derive(Clone, Copy, Debug)]
pub struct Law([f64; 4]);

impl Law {
    fn at(&self, v: f64) -> [f64; 2] {
        let [a, b, c, d] = self.0;
        [a + v * (b + v * (c + v * d)), b + v * (2.0 * c + v * 3.0 * d)]
    }
}

/// The scheme's numbers, computed from its definition.
pub struct Tableau {
    pub c: [f64; S],
    a: [[f64; S]; S],
    /// From the values at 0 and the stages to the coefficient of the highest Legendre polynomial.
    tail: [f64; S + 1],
    samples: [[f64; S + 1]; SAMPLES],
}

pub static RADAU: LazyLock<Tableau> = LazyLock::new(Tableau::new);

/// Legendre's polynomials P_n and P_(n-1).
fn legendre(n: usize, x: f64) -> [f64; 2] {
    (1..n).fold([x, 1.0], |[p, q], k| {
        let k = k as f64;
        [((2.0 * k + 1.0) * x * p - k * q) / (k + 1.0), p]
    })
}

/// Roots of a function in -1..1, by bisection of the intervals of a fine mesh.
fn roots(function: impl Fn(f64) -> f64) -> Vec<f64> {
    let mesh = |i: i32| -1.0 + f64::from(i) / 1500.5;
    (0..3001)
        .map(|i| (mesh(i), mesh(i + 1).min(1.0 - 1e-9)))
        .filter(|&(low, high)| function(low) * function(high) < 0.0)
        .map(|(low, high)| {
            let (mut low, mut high) = (low, high);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if function(low) * function(middle) <= 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            0.5 * (low + high)
        })
        .collect()
}

/// The Lagrange polynomial of node j.
fn lagrange(nodes: &[f64], j: usize, t: f64) -> f64 {
    let others = nodes.iter().enumerate().filter(|&(i, _)| i != j);
    others.map(|(_, node)| (t - node) / (nodes[j] - node)).product()
}

impl Tableau {
    fn new() -> Self {
        let radau = roots(|x| {
            let [p, q] = legendre(S, x);
            p - q
        });
        assert_eq!(radau.len(), S - 1, "the last node is 1");
        let c: [f64; S] = std::array::from_fn(|i| radau.get(i).map_or(1.0, |x| 0.5 * (x + 1.0)));
        let gauss: Vec<[f64; 2]> = roots(|x| legendre(S + 1, x)[0])
            .into_iter()
            .map(|x| {
                let [p, q] = legendre(S + 1, x);
                let derivative = (S + 1) as f64 * (x * p - q) / (x * x - 1.0);
                [0.5 * (x + 1.0), 1.0 / ((1.0 - x * x) * derivative * derivative)]
            })
            .collect();
        let integral = |end: f64, f: &dyn Fn(f64) -> f64| -> f64 {
            end * gauss.iter().map(|[t, weight]| weight * f(end * t)).sum::<f64>()
        };
        let a = std::array::from_fn(|i| std::array::from_fn(|j| integral(c[i], &|t| lagrange(&c, j, t))));
        let mut nodes = [0.0; S + 1];
        nodes[1..].copy_from_slice(&c);
        let tail = std::array::from_fn(|j| {
            (2 * S + 1) as f64 * integral(1.0, &|t| lagrange(&nodes, j, t) * legendre(S, 2.0 * t - 1.0)[0])
        });
        let samples = std::array::from_fn(|i| {
            let t = (i + 1) as f64 / SAMPLES as f64;
            std::array::from_fn(|j| lagrange(&nodes, j, t))
        });
        Self { c, a, tail, samples }
    }

    /// The collocation polynomial at `t` in units of the step.
    pub fn interpolated(&self, values: &[f64; S + 1], t: f64) -> f64 {
        let node = |i: usize| if i == 0 { 0.0 } else { self.c[i - 1] };
        (0..=S)
            .map(|j| {
                let others = (0..=S).filter(|&i| i != j);
                values[j] * others.map(|i| (t - node(i)) / (node(j) - node(i))).product::<f64>()
            })
            .sum()
    }

    /// Its values at multiples of 1/[`SAMPLES`].
    pub fn sampled(&self, values: &[f64; S + 1]) -> [f64; SAMPLES] {
        std::array::from_fn(|i| self.samples[i].iter().zip(values).map(|(s, v)| s * v).sum())
    }

    /// How much of it is in the highest Legendre polynomial: the part that one stage less would miss.
    pub fn tail(&self, values: &[f64; S + 1]) -> f64 {
        self.tail.iter().zip(values).map(|(t, v)| t * v).sum::<f64>().abs()
    }
}

/// Where a step begins, and on which piece.
#[derive(Clone, Copy, Debug)]
pub struct Start<'a> {
    pub bush: &'a Bush,
    pub law: Law,
    pub tau: f64,
    pub x: f64,
    pub v: f64,
    /// The size of v that counts.
    pub scale: f64,
}

/// A step that was taken.
pub struct Step {
    pub h: f64,
    /// At its beginning and its stages, the last of which is its end.
    pub x: [f64; S + 1],
    pub v: [f64; S + 1],
    /// Integral of the divergence.
    pub divergence: f64,
    /// Greatest |d v'/dv|.
    pub rate: f64,
    slopes: [[f64; 2]; S],
    matrix: Lu,
}

impl Start<'_> {
    /// A step of `h` from guessed stages of v; None if Newton's method does not converge.
    pub fn step(&self, h: f64, guess: [f64; S]) -> Option<Step> {
        let tableau = &*RADAU;
        let a = &tableau.a;
        let shaft: [[f64; 2]; S] = std::array::from_fn(|i| self.bush.shaft(self.tau + tableau.c[i] * h));
        let mut v = guess;
        let mut last = f64::INFINITY;
        for _ in 0..12 {
            let (x, rates) = self.stages(h, &shaft, &v);
            let matrix = Lu::new(newton_matrix(a, h, &rates))?;
            let mut change: [f64; S] = std::array::from_fn(|i| {
                let sum: f64 = (0..S).map(|j| a[i][j] * rates[j][0]).sum();
                self.v + h * sum - v[i]
            });
            matrix.solve(&mut change);
            for i in 0..S {
                v[i] += change[i];
            }
            let size = change.iter().fold(0.0, |most: f64, c| most.max(c.abs())) / self.scale;
            if !size.is_finite() || !x[S - 1].is_finite() {
                return None;
            }
            // quadratic convergence: the next change would be below rounding; or it is rounding that is left
            if size < 1e-10 || (size < 1e-6 && size > 0.1 * last) {
                return self.taken(h, &shaft, v);
            }
            last = size;
        }
        None
    }

    fn stages(&self, h: f64, shaft: &[[f64; 2]; S], v: &[f64; S]) -> ([f64; S], [[f64; 3]; S]) {
        let a = &RADAU.a;
        let x = std::array::from_fn(|i| self.x + h * (0..S).map(|j| a[i][j] * (shaft[j][0] - v[j])).sum::<f64>());
        let rates = std::array::from_fn(|i| self.bush.rate_at(&self.law, shaft[i][0], shaft[i][1], x[i], v[i]));
        (x, rates)
    }

    fn taken(&self, h: f64, shaft: &[[f64; 2]; S], v: [f64; S]) -> Option<Step> {
        let (x, rates) = self.stages(h, shaft, &v);
        let with_start =
            |start: f64, stages: &[f64; S]| std::array::from_fn(|i| if i == 0 { start } else { stages[i - 1] });
        Some(Step {
            h,
            x: with_start(self.x, &x),
            v: with_start(self.v, &v),
            divergence: h * (0..S).map(|j| RADAU.a[S - 1][j] * rates[j][2]).sum::<f64>(),
            rate: rates.iter().fold(0.0, |most: f64, r| most.max(r[2].abs())),
            slopes: rates.map(|r| [r[1], r[2]]),
            matrix: Lu::new(newton_matrix(&RADAU.a, h, &rates))?,
        })
    }
}

/// I - h A (D_v - D_x h A).
fn newton_matrix(a: &[[f64; S]; S], h: f64, rates: &[[f64; 3]; S]) -> [[f64; S]; S] {
    std::array::from_fn(|i| {
        let row: [f64; S] = std::array::from_fn(|k| h * a[i][k] * rates[k][1] * h);
        std::array::from_fn(|j| {
            let product: f64 = (0..S).map(|k| row[k] * a[k][j]).sum();
            f64::from(u8::from(i == j)) - h * a[i][j] * rates[j][2] + product
        })
    })
}

impl Step {
    pub fn end(&self) -> [f64; 2] {
        [self.x[S], self.v[S]]
    }

    /// A tangent vector (dx, dv) at the end, from that at the beginning.
    pub fn tangent(&self, [dx, dv]: [f64; 2]) -> [f64; 2] {
        let a = &RADAU.a;
        let mut stages: [f64; S] = std::array::from_fn(|i| {
            let forced: f64 = (0..S).map(|j| a[i][j] * self.slopes[j][0]).sum();
            dv + self.h * forced * dx
        });
        self.matrix.solve(&mut stages);
        let moved: f64 = (0..S).map(|j| a[S - 1][j] * stages[j]).sum();
        [dx - self.h * moved, stages[S - 1]]
    }
}

/// A matrix factorised with row pivots.
struct Lu {
    m: [[f64; S]; S],
    pivots: [usize; S],
}

impl Lu {
    fn new(mut m: [[f64; S]; S]) -> Option<Self> {
        let mut pivots = [0; S];
        for k in 0..S {
            let pivot = (k..S).max_by(|&i, &j| m[i][k].abs().total_cmp(&m[j][k].abs()))?;
            m.swap(k, pivot);
            pivots[k] = pivot;
            if m[k][k] == 0.0 || !m[k][k].is_finite() {
                return None;
            }
            let row = m[k];
            for below in &mut m[k + 1..] {
                below[k] /= row[k];
                for j in k + 1..S {
                    below[j] -= below[k] * row[j];
                }
            }
        }
        Some(Self { m, pivots })
    }

    fn solve(&self, r: &mut [f64; S]) {
        for k in 0..S {
            r.swap(k, self.pivots[k]);
        }
        for i in 1..S {
            r[i] -= (0..i).map(|j| self.m[i][j] * r[j]).sum::<f64>();
        }
        for i in (0..S).rev() {
            r[i] = (r[i] - (i + 1..S).map(|j| self.m[i][j] * r[j]).sum::<f64>()) / self.m[i][i];
        }
    }
}
