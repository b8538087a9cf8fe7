//! Vectors of x86-64: AVX2 with FMA, and AVX-512.
//!
//! Owns the intrinsics. The module's rule: a value of one of these types is made and used only inside a function whose
//! `target_feature` enables the instruction set, and which is called only after the set was detected at run time. That is why
//! only the proofs of the parent module name the types.

use std::arch::asm;
#[expect(clippy::wildcard_imports, reason = "the names of intrinsics show their origin")]
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::lanes::{LONG_PERIOD_TICKS, Mask, ROUNDING, Real, SHORT_PERIOD_TICKS, Ticks};

/// A number whose sign bit is its only bit that is 1.
const SIGN_F64: f64 = -0.0;
const SIGN_F32: f32 = -0.0;

/// A clock below this is at 0: clocks hold whole ticks.
const HALF_TICK: f64 = 0.5;

macro_rules! x86_vector {
    (
        $(#[$doc:meta])* $name:ident: $lanes:literal x $scalar:ident in $register:ident,
        $mask:ident($mask_register:ident) = |$m:ident| $bits:expr;
        $add:ident $sub:ident $mul:ident $div:ident $fma:ident $min:ident $max:ident $sqrt:ident $set:ident $load:ident
        $store:ident, abs = |$a:ident| $abs:expr, less = |$l:ident, $r:ident| $less:expr,
        select = |$s:ident, $yes:ident, $no:ident| $select:expr,
        and = |$and_a:ident, $and_b:ident| $and:expr, or = |$or_a:ident, $or_b:ident| $or:expr,
        $ticks:ident of $period_ticks:ident, to = |$value:ident| $to_ticks:expr, from = |$t:ident| $from_ticks:expr,
        $tie:ident($tie_register:ident) for $feature:literal
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub(super) struct $name($register);

        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub(super) struct $mask($mask_register);

        // AVX-512 masks are plain integers, whose operations are safe
        #[allow(unused_unsafe)]
        #[allow(clippy::cast_lossless, reason = "the bits' type depends on the instruction set")]
        impl Mask for $mask {
            const LANES: usize = $lanes;

            #[inline(always)]
            fn all(self) -> bool {
                let $m = self.0;
                // SAFETY: the module's rule.
                let bits = unsafe { $bits } as u32;
                let every_lane = (1u32 << $lanes) - 1;
                bits & every_lane == every_lane
            }
            #[inline(always)]
            fn lane(self, lane: usize) -> bool {
                let $m = self.0;
                // SAFETY: the module's rule.
                (unsafe { $bits } as u32) >> lane & 1 == 1
            }
            #[inline(always)]
            fn and(self, other: Self) -> Self {
                let ($and_a, $and_b) = (self.0, other.0);
                // SAFETY: the module's rule.
                Self(unsafe { $and })
            }
            #[inline(always)]
            fn or(self, other: Self) -> Self {
                let ($or_a, $or_b) = (self.0, other.0);
                // SAFETY: the module's rule.
                Self(unsafe { $or })
            }
        }

        /// Executes nothing, but the compiler must assume that it changes both registers.
        #[target_feature(enable = $feature)]
        #[inline]
        fn $tie(a: &mut $register, b: &mut $register) {
            // SAFETY: nothing is executed.
            unsafe {
                asm!("/* {0} {1} */", inout($tie_register) *a, inout($tie_register) *b,
                    options(pure, nomem, nostack, preserves_flags));
            }
        }

        x86_vector!(@operator $name Add add $add);
        x86_vector!(@operator $name Sub sub $sub);
        x86_vector!(@operator $name Mul mul $mul);
        x86_vector!(@operator $name Div div $div);

        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::broadcast(0.0) - self
            }
        }

        impl Real for $name {
            type Mask = $mask;
            type Ticks = $ticks;
            type Scalar = $scalar;
            const LANES: usize = $lanes;
            const VECTORS: usize = 1;
            const PERIOD_TICKS: f64 = $period_ticks;
            undivided!();

            #[inline(always)]
            fn scalar(value: f64) -> $scalar {
                value as $scalar
            }
            #[inline(always)]
            fn broadcast(value: $scalar) -> Self {
                // SAFETY: the module's rule.
                Self(unsafe { $set(value) })
            }
            #[inline(always)]
            fn from_lanes(mut values: impl FnMut(usize) -> f64) -> Self {
                let mut array = [0.0 as $scalar; $lanes];
                for lane in 0..$lanes {
                    array[lane] = values(lane) as $scalar;
                }
                // SAFETY: the module's rule; the array has the register's length.
                Self(unsafe { $load(array.as_ptr()) })
            }
            #[inline(always)]
            fn lane(self, lane: usize) -> f64 {
                let mut array = [0.0 as $scalar; $lanes];
                // SAFETY: the module's rule; the array has the register's length.
                unsafe { $store(array.as_mut_ptr(), self.0) };
                f64::from(array[lane])
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, addend: Self) -> Self {
                // SAFETY: the module's rule.
                Self(unsafe { $fma(self.0, factor.0, addend.0) })
            }
            #[inline(always)]
            fn abs(self) -> Self {
                let $a = self.0;
                // SAFETY: the module's rule.
                Self(unsafe { $abs })
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                // SAFETY: the module's rule.
                Self(unsafe { $min(self.0, other.0) })
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: the module's rule.
                Self(unsafe { $max(self.0, other.0) })
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: the module's rule.
                Self(unsafe { $sqrt(self.0) })
            }
            #[inline(always)]
            fn less(self, other: Self) -> $mask {
                let ($l, $r) = (self.0, other.0);
                // SAFETY: the module's rule.
                $mask(unsafe { $less })
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                let ($s, $yes, $no) = (mask.0, yes.0, no.0);
                // SAFETY: the module's rule.
                Self(unsafe { $select })
            }
            #[inline(always)]
            fn to_ticks(self) -> $ticks {
                let $value = self;
                $to_ticks
            }
            #[inline(always)]
            fn from_ticks(ticks: $ticks) -> Self {
                let $t = ticks;
                $from_ticks
            }
            #[inline(always)]
            fn together(mut self, mut other: Self) -> (Self, Self) {
                // SAFETY: the module's rule.
                unsafe { $tie(&mut self.0, &mut other.0) };
                (self, other)
            }
        }
    };
    (@operator $name:ident $trait:ident $method:ident $intrinsic:ident) => {
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the module's rule.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

/// A clock of 32-bit integers in every lane, beside a vector of f32.
macro_rules! integer_ticks {
    ($ticks:ident($register:ident) for $real:ident: $set:ident $sub:ident $min:ident $to:ident $from:ident,
        zero = |$z:ident| $zero:expr) => {
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub(super) struct $ticks($register);

        impl $ticks {
            #[inline(always)]
            fn of(value: $real) -> Self {
                // SAFETY: the module's rule.
                Self(unsafe { $to(value.0) })
            }
            #[inline(always)]
            fn value(self) -> $real {
                // SAFETY: the module's rule.
                $real(unsafe { $from(self.0) })
            }
        }

        impl Ticks for $ticks {
            #[inline(always)]
            fn splat(ticks: f64) -> Self {
                // SAFETY: the module's rule.
                Self(unsafe { $set(ticks as i32) })
            }
            #[inline(always)]
            fn minus(self, other: Self) -> Self {
                // SAFETY: the module's rule.
                Self(unsafe { $sub(self.0, other.0) })
            }
            #[inline(always)]
            fn least(self, other: Self) -> Self {
                // SAFETY: the module's rule.
                Self(unsafe { $min(self.0, other.0) })
            }
            #[inline(always)]
            fn all_zero(self) -> bool {
                let $z = self.0;
                // SAFETY: the module's rule.
                unsafe { $zero }
            }
        }
    };
}

/// A vector of f64 as the clock in its own lanes.
macro_rules! own_ticks {
    ($real:ident) => {
        impl Ticks for $real {
            #[inline(always)]
            fn splat(ticks: f64) -> Self {
                Self::broadcast(ticks)
            }
            #[inline(always)]
            fn minus(self, other: Self) -> Self {
                self - other
            }
            #[inline(always)]
            fn least(self, other: Self) -> Self {
                self.min(other)
            }
            #[inline(always)]
            fn all_zero(self) -> bool {
                self.less(Self::broadcast(HALF_TICK)).all()
            }
        }
    };
}

x86_vector! {
    /// Eight f64 (AVX-512F).
    F64x8: 8 x f64 in __m512d, F64x8Mask(__mmask8) = |m| m;
    _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_fmadd_pd _mm512_min_pd _mm512_max_pd
    _mm512_sqrt_pd _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd,
    abs = |a| _mm512_abs_pd(a), less = |l, r| _mm512_cmp_pd_mask::<_CMP_LT_OQ>(l, r),
    select = |s, yes, no| _mm512_mask_blend_pd(s, no, yes),
    and = |a, b| a & b, or = |a, b| a | b,
    F64x8 of LONG_PERIOD_TICKS, to = |v| v + Self::broadcast(ROUNDING) - Self::broadcast(ROUNDING), from = |t| t,
    tie_f64x8(zmm_reg) for "avx512f"
}

x86_vector! {
    /// Sixteen f32 (AVX-512F).
    F32x16: 16 x f32 in __m512, F32x16Mask(__mmask16) = |m| m;
    _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_fmadd_ps _mm512_min_ps _mm512_max_ps
    _mm512_sqrt_ps _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps,
    abs = |a| _mm512_abs_ps(a), less = |l, r| _mm512_cmp_ps_mask::<_CMP_LT_OQ>(l, r),
    select = |s, yes, no| _mm512_mask_blend_ps(s, no, yes),
    and = |a, b| a & b, or = |a, b| a | b,
    I32x16 of SHORT_PERIOD_TICKS, to = |v| I32x16::of(v), from = |t| t.value(),
    tie_f32x16(zmm_reg) for "avx512f"
}

x86_vector! {
    /// Four f64 (AVX2 and FMA).
    F64x4: 4 x f64 in __m256d, F64x4Mask(__m256d) = |m| _mm256_movemask_pd(m);
    _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_fmadd_pd _mm256_min_pd _mm256_max_pd
    _mm256_sqrt_pd _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd,
    abs = |a| _mm256_andnot_pd(_mm256_set1_pd(SIGN_F64), a), less = |l, r| _mm256_cmp_pd::<_CMP_LT_OQ>(l, r),
    select = |s, yes, no| _mm256_blendv_pd(no, yes, s),
    and = |a, b| _mm256_and_pd(a, b), or = |a, b| _mm256_or_pd(a, b),
    F64x4 of LONG_PERIOD_TICKS, to = |v| v + Self::broadcast(ROUNDING) - Self::broadcast(ROUNDING), from = |t| t,
    tie_f64x4(ymm_reg) for "avx"
}

x86_vector! {
    /// Eight f32 (AVX2 and FMA).
    F32x8: 8 x f32 in __m256, F32x8Mask(__m256) = |m| _mm256_movemask_ps(m);
    _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_fmadd_ps _mm256_min_ps _mm256_max_ps
    _mm256_sqrt_ps _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps,
    abs = |a| _mm256_andnot_ps(_mm256_set1_ps(SIGN_F32), a), less = |l, r| _mm256_cmp_ps::<_CMP_LT_OQ>(l, r),
    select = |s, yes, no| _mm256_blendv_ps(no, yes, s),
    and = |a, b| _mm256_and_ps(a, b), or = |a, b| _mm256_or_ps(a, b),
    I32x8 of SHORT_PERIOD_TICKS, to = |v| I32x8::of(v), from = |t| t.value(),
    tie_f32x8(ymm_reg) for "avx"
}

own_ticks!(F64x8);
own_ticks!(F64x4);
integer_ticks!(I32x16(__m512i) for F32x16: _mm512_set1_epi32 _mm512_sub_epi32 _mm512_min_epi32 _mm512_cvttps_epi32
    _mm512_cvtepi32_ps, zero = |a| _mm512_test_epi32_mask(a, a) == 0);
integer_ticks!(I32x8(__m256i) for F32x8: _mm256_set1_epi32 _mm256_sub_epi32 _mm256_min_epi32 _mm256_cvttps_epi32
    _mm256_cvtepi32_ps, zero = |a| _mm256_testz_si256(a, a) == 1);
