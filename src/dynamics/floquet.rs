//! The linearised motion over one turn near a cycle.
//!
//! Owns Floquet multipliers, and the step of Newton's method towards the cycle; integrates nothing. [`plane`] has the motion at
//! constant contact pressure, whose state is (x, y); [`space`] any other.

pub mod plane;
pub mod space;

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector};

/// The derivative of the map that takes a state over one turn.
pub trait Linearisation {
    /// The step of Newton's method from a state to the cycle, given how far one turn has moved the state. None if the derivative has
    /// the eigenvalue 1.
    fn newton_step(&self, moved: &[f64]) -> Option<Vec<f64>>;

    /// Whether an orbit goes to the cycle, whose deviation from it is `from`, and `to` one turn later. The turn need not be that of
    /// the derivative exactly: it may differ by half of what the derivative contracts. Deviations are measured by the length of
    /// their whole future, the sum of their squares over all turns, which decreases in every turn if the derivative alone decides.
    fn attracts(&self, from: &[f64], to: &[f64]) -> bool;
}

/// The two greatest eigenvalues mu_1, mu_2 of a monodromy matrix, |mu_1| >= |mu_2|. Logarithms, since products of many stiff periods
/// overflow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multipliers {
    /// ln |mu_1| and ln |mu_2|; divided by the time of a turn, they are the exponents.
    pub log_moduli: [f64; 2],
    /// The cosine of mu_1's angle: 1 or -1 if mu_1 is real.
    pub cosine: f64,
}

impl Multipliers {
    /// mu_1 if it is real, else 0: the factor of the distance from an attracting cycle in one turn.
    pub fn leading(&self) -> f64 {
        if self.cosine.abs() < 1.0 {
            0.0
        } else {
            self.log_moduli[0].exp() * self.cosine
        }
    }

    /// |1 - mu_1|: the distance that an orbit moves in a turn, over its distance from an attracting cycle.
    pub fn distance_from_one(&self) -> f64 {
        let modulus = self.log_moduli[0].exp();
        (1.0 - 2.0 * modulus * self.cosine + modulus * modulus).max(0.0).sqrt()
    }
}

/// Turns, as a power of two, after which nothing is left of a deviation.
const DOUBLINGS: u32 = 16;

/// A power of the matrix with a norm below this adds nothing more.
const NOTHING: f64 = 1e-12;

/// [`Linearisation::attracts`], given the monodromy matrix.
fn attracts<D: Dim>(matrix: &OMatrix<f64, D, D>, from: &OVector<f64, D>, to: &OVector<f64, D>) -> bool
where
    DefaultAllocator: Allocator<D, D> + Allocator<D>,
{
    let (size, _) = matrix.shape_generic();
    let mut future = OMatrix::<f64, D, D>::identity_generic(size, size);
    let mut power = matrix.clone();
    for _ in 0..DOUBLINGS {
        future += power.tr_mul(&(&future * &power));
        power = &power * &power;
        if power.norm() < NOTHING {
            break;
        }
    }
    let measure = |v: &OVector<f64, D>| v.dot(&(&future * v)).sqrt();
    let expected = matrix * from;
    measure(&(to - &expected)) < 0.5 * (measure(from) - measure(&expected))
}
