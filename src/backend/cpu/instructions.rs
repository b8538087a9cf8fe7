//! The vector instructions of this machine.
//!
//! Owns their detection; the lanes that use them are [`crate::lanes`]'.

use crate::experiment::Precision;
#[cfg(all(target_arch = "x86_64", not(test)))]
use crate::lanes::x86;

/// A set of vector instructions that the lanes are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionSet {
    Avx512,
    Avx2,
    /// The instructions that every machine of the target has (SSE2 on x86-64, NEON on aarch64).
    Portable,
}

impl InstructionSet {
    /// The instruction sets that this machine has, the fastest first.
    pub fn available() -> Vec<Self> {
        [Self::Avx512, Self::Avx2, Self::Portable]
            .into_iter()
            .filter(|set| set.is_available())
            .collect()
    }

    #[cfg(all(target_arch = "x86_64", not(test)))]
    fn is_available(self) -> bool {
        match self {
            Self::Avx512 => x86::Avx512::detect().is_some(),
            Self::Avx2 => x86::Avx2::detect().is_some(),
            Self::Portable => true,
        }
    }

    #[cfg(any(test, not(target_arch = "x86_64")))]
    fn is_available(self) -> bool {
        self == Self::Portable
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "AVX-512",
            Self::Avx2 => "AVX2 + FMA",
            Self::Portable => "portable",
        }
    }

    /// Numbers in one vector register; for the portable set, numbers that are worked on together.
    pub fn lanes(self, precision: Precision) -> usize {
        match (self, precision) {
            (Self::Avx512, Precision::F64) | (Self::Avx2, Precision::F32) => 8,
            (Self::Avx512, Precision::F32) => 16,
            (Self::Avx2, Precision::F64) | (Self::Portable, _) => 4,
        }
    }
}
