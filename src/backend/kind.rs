//! Kinds of backends: devices and number types.

use serde::{Deserialize, Serialize};

/// Where and in which number type an instance was integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BackendKind {
    CpuF64,
    CpuF32,
    GpuF32,
}

impl BackendKind {
    /// Names in files, in the order of the variants.
    pub const NAMES: &[&str] = &["cpu_f64", "cpu_f32", "gpu_f32"];

    /// The name in files.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Distance from 1 to the next larger number of the number type.
    pub fn epsilon(self) -> f64 {
        match self {
            Self::CpuF64 => f64::EPSILON,
            Self::CpuF32 | Self::GpuF32 => f32::EPSILON.into(),
        }
    }

    /// `cpu` or `gpu`.
    pub fn device_class(self) -> &'static str {
        match self {
            Self::CpuF64 | Self::CpuF32 => "cpu",
            Self::GpuF32 => "gpu",
        }
    }

    /// The number type: `f64` or `f32`.
    pub fn precision(self) -> &'static str {
        match self {
            Self::CpuF64 => "f64",
            Self::CpuF32 | Self::GpuF32 => "f32",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_in_files() {
        for kind in [BackendKind::CpuF64, BackendKind::CpuF32, BackendKind::GpuF32] {
            assert_eq!(serde_json::to_value(kind).unwrap(), kind.name());
        }
    }
}
