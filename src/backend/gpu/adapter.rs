//! The GPU adapters of the machine, and the choice among them.
//!
//! Owns the choice of an adapter, and the message if there is none; opens no device.

use std::fmt;

use crate::backend::BackendError;

/// Description of an adapter for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterDescription {
    pub name: String,
    /// The programming interface: Vulkan, Metal, ...
    pub backend: String,
    pub device_type: String,
    pub driver: String,
    /// Whether it is not a GPU, but a program that acts as one on the CPU.
    pub is_software: bool,
}

impl fmt::Display for AdapterDescription {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {})", self.name, self.backend, self.device_type)
    }
}

impl AdapterDescription {
    /// Whether `part` occurs in the name, in upper or lower case.
    pub fn is_named(&self, part: &str) -> bool {
        self.name.to_lowercase().contains(&part.to_lowercase())
    }

    pub(super) fn new(info: &wgpu::AdapterInfo) -> Self {
        Self {
            name: info.name.clone(),
            backend: match info.backend {
                wgpu::Backend::Vulkan => "Vulkan",
                wgpu::Backend::Metal => "Metal",
                wgpu::Backend::Dx12 => "DirectX 12",
                wgpu::Backend::Gl => "OpenGL",
                wgpu::Backend::BrowserWebGpu => "WebGPU",
                wgpu::Backend::Noop => "no-op",
            }
            .to_owned(),
            device_type: match info.device_type {
                wgpu::DeviceType::DiscreteGpu => "discrete GPU",
                wgpu::DeviceType::IntegratedGpu => "integrated GPU",
                wgpu::DeviceType::VirtualGpu => "virtual GPU",
                wgpu::DeviceType::Cpu => "software",
                wgpu::DeviceType::Other => "GPU of unknown type",
            }
            .to_owned(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            is_software: info.device_type == wgpu::DeviceType::Cpu,
        }
    }
}

/// The adapters of this machine, the preferred one first.
pub fn adapters() -> Vec<AdapterDescription> {
    enumerate()
        .iter()
        .map(|adapter| AdapterDescription::new(&adapter.get_info()))
        .collect()
}

fn enumerate() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.retain(|adapter| adapter.get_info().backend != wgpu::Backend::Noop);
    adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
    adapters
}

/// Order of preference: hardware before software, large before small; OpenGL is the last of a device's interfaces.
fn rank(info: &wgpu::AdapterInfo) -> (u8, bool) {
    let device = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    (device, info.backend == wgpu::Backend::Gl)
}

/// The first adapter with `name` in its name, in upper or lower case; a software adapter only if that is allowed.
///
/// # Errors
/// [`BackendError::NoDevice`], saying which adapters there are and what to do.
pub(super) fn choose(name: Option<&str>, allow_software: bool) -> Result<wgpu::Adapter, BackendError> {
    let adapters = enumerate();
    let descriptions: Vec<_> = adapters
        .iter()
        .map(|adapter| AdapterDescription::new(&adapter.get_info()))
        .collect();
    let index = choose_index(&descriptions, name, allow_software).map_err(BackendError::NoDevice)?;
    Ok(adapters.into_iter().nth(index).expect("the index is of this list"))
}

/// All hardware adapters with `name` in their name, each GPU once: those of the interface that the preferred one has.
pub(super) fn all_hardware(name: Option<&str>) -> Vec<wgpu::Adapter> {
    let mut adapters = enumerate();
    let is_wanted = |info: &wgpu::AdapterInfo| {
        info.device_type != wgpu::DeviceType::Cpu && AdapterDescription::new(info).is_named(name.unwrap_or_default())
    };
    adapters.retain(|adapter| is_wanted(&adapter.get_info()));
    let preferred = adapters.first().map(|adapter| adapter.get_info().backend);
    adapters.retain(|adapter| Some(adapter.get_info().backend) == preferred);
    adapters
}

fn choose_index(adapters: &[AdapterDescription], name: Option<&str>, allow_software: bool) -> Result<usize, String> {
    let is_named = |adapter: &AdapterDescription| adapter.is_named(name.unwrap_or_default());
    if let Some(index) = adapters
        .iter()
        .position(|adapter| is_named(adapter) && (allow_software || !adapter.is_software))
    {
        return Ok(index);
    }
    let list = adapters.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    Err(match name {
        _ if adapters.is_empty() => {
            "no GPU was found: install its Vulkan, Metal or DirectX 12 driver, or use --backend cpu".to_owned()
        }
        Some(name) if !adapters.iter().any(is_named) => {
            format!("no GPU adapter has `{name}` in its name: give part of one of {list}; or use --backend cpu")
        }
        _ => format!(
            "no hardware GPU was found{}, only a software adapter, which is slower than the CPU backend: use --backend \
             cpu, or name it with --adapter to use it all the same; there are: {list}",
            name.map(|name| format!(" with `{name}` in its name"))
                .unwrap_or_default()
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(name: &str, is_software: bool) -> AdapterDescription {
        AdapterDescription {
            name: name.to_owned(),
            backend: "Vulkan".to_owned(),
            device_type: if is_software { "software" } else { "discrete GPU" }.to_owned(),
            driver: String::new(),
            is_software,
        }
    }

    #[test]
    fn hardware_is_taken_first_and_software_only_where_allowed() {
        let both = [adapter("NVIDIA H200", false), adapter("llvmpipe", true)];
        assert_eq!(choose_index(&both, None, true), Ok(0));
        assert_eq!(choose_index(&both, Some("nvidia"), false), Ok(0));
        assert_eq!(choose_index(&both, Some("LLVM"), true), Ok(1));
        assert_eq!(choose_index(&both[1..], None, true), Ok(0));
    }

    #[test]
    fn refusals_say_what_there_is_and_what_to_do() {
        let software = [adapter("llvmpipe", true)];
        for (adapters, name, says) in [
            (&[][..], None, "no GPU was found"),
            (&software, None, "only a software adapter"),
            (&software, Some("llvm"), "llvmpipe (Vulkan, software)"),
            (
                &software,
                Some("radeon"),
                "no GPU adapter has `radeon` in its name: give part of one of llvmpipe",
            ),
        ] {
            let message = choose_index(adapters, name, false).unwrap_err();
            assert!(message.contains(says) && message.contains("--backend cpu"), "{message}");
        }
    }
}
