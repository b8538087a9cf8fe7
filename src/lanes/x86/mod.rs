//! The instruction sets of x86-64 that lanes are compiled for, as proofs that the machine has them.
//!
//! Owns detection, and the functions that are compiled for the instruction sets; computes nothing. Vectors are used only inside
//! such a function. Code that works over lanes gets them as the type parameter of [`OverLanes`], and stores what it makes of
//! them as [`Held`](super::Held), which gives access to it only inside such a function.

mod vectors;

use self::vectors::{F32x8, F32x16, F64x4, F64x8};
use super::{Instructions, Real};

/// Work over a type of lanes that is chosen at run time.
pub(crate) trait OverLanes {
    type Output;

    /// Carries the work out in vectors `V` of the instructions `I`.
    fn carry_out<I: Instructions, V: Real + Send + Sync + 'static>(self, instructions: I) -> Self::Output;
}

/// A local variable as long as a cache line, and aligned to one.
///
/// The compiler aligns a function's stack for variables, but not for vectors that it spills because registers run out. Without
/// such a variable most spilled vectors straddle two cache lines, and every access to them takes twice as long.
#[repr(align(64))]
struct CacheLine([u8; 64]);

macro_rules! x86_instructions {
    ($(#[$doc:meta])* $name:ident: [$($feature:tt)*] $f64:ident $f32:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(crate) struct $name(());

        impl $name {
            /// None if the machine does not have these instructions.
            pub fn detect() -> Option<Self> {
                let is_there = $(is_x86_feature_detected!($feature))&&*;
                is_there.then_some(Self(()))
            }

            /// Carries work out over their lanes of f64.
            pub fn over_f64<W: OverLanes>(self, work: W) -> W::Output {
                self.carry_out(work, |work| work.carry_out::<Self, $f64>(self))
            }

            /// Carries work out over their lanes of f32.
            pub fn over_f32<W: OverLanes>(self, work: W) -> W::Output {
                self.carry_out(work, |work| work.carry_out::<Self, $f32>(self))
            }
        }

        impl Instructions for $name {
            #[inline(always)]
            fn carry_out<T, U>(self, value: T, work: impl FnOnce(T) -> U) -> U {
                #[target_feature($(enable = $feature),*)]
                fn enabled<T, U>(value: T, work: impl FnOnce(T) -> U) -> U {
                    let line = CacheLine([0; size_of::<CacheLine>()]);
                    std::hint::black_box(&line.0);
                    work(value)
                }
                // SAFETY: `self` exists only if the machine was found to have these instructions.
                unsafe { enabled(value, work) }
            }
        }
    };
}

x86_instructions! {
    /// AVX-512F, on a machine with AVX2 and FMA.
    Avx512: ["avx512f" "avx2" "fma"] F64x8 F32x16
}

x86_instructions! {
    /// AVX2 and FMA.
    Avx2: ["avx2" "fma"] F64x4 F32x8
}
