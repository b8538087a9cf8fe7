//! What a shader's module says of itself, held against the host's side: layouts, bindings, constants, and translation to
//! every target language.
//!
//! Owns the comparison; which structs, bindings and kernels there are is each test's.

use std::collections::{BTreeMap, BTreeSet};

use naga::back::{PipelineConstants, hlsl, msl, pipeline_constants, spv};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, GlobalVariable, Module, ScalarKind, ShaderStage, StorageAccess, TypeInner};
use tribochaos::backend::gpu::layout::{Access, Binding};
use tribochaos::backend::gpu::shader_source::{Kernel, Shader};

/// Threads in the workgroups that are asked for.
const WORKGROUP_SIZE: u32 = 64;

pub fn parsed(source: &str) -> Module {
    naga::front::wgsl::parse_str(source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)))
}

/// Valid with nothing beyond what every WebGPU device has.
pub fn validated(module: &Module, source: &str) -> ModuleInfo {
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)))
}

/// Name, offset and type of every field, and the whole size.
pub type Layout = (Vec<(String, usize, String)>, usize);

/// Name and layout of a struct of the host.
macro_rules! layout_of {
    ($type:ident { $($field:ident),* $(,)? }) => {{
        // naming every field here makes one that is left out a compile error
        let $type { $($field),* } = bytemuck::Zeroable::zeroed();
        let fields = vec![$((
            stringify!($field).to_owned(),
            std::mem::offset_of!($type, $field),
            std::any::type_name_of_val(&$field).to_owned(),
        )),*];
        (stringify!($type), (fields, size_of::<$type>()))
    }};
}
pub(crate) use layout_of;

fn scalar_name(inner: &TypeInner) -> String {
    match inner {
        TypeInner::Scalar(scalar) if scalar.width == 4 => match scalar.kind {
            ScalarKind::Float => "f32".to_owned(),
            ScalarKind::Uint => "u32".to_owned(),
            other => panic!("a shared struct holds a {other:?}"),
        },
        other => panic!("a shared struct holds {other:?}, which is no scalar of 4 bytes"),
    }
}

/// Number and variable of every binding of group 0; there is no other group.
fn bound(module: &Module) -> impl Iterator<Item = (u32, &GlobalVariable)> {
    module.global_variables.iter().filter_map(|(_, global)| {
        let resource = global.binding?;
        assert_eq!(resource.group, 0);
        Some((resource.binding, global))
    })
}

/// Every struct that is bound is laid out as the host's of its name, and every one of the host's is bound.
pub fn assert_layouts(module: &Module, rust: &BTreeMap<&'static str, Layout>) {
    let mut compared = BTreeSet::new();
    for (_, global) in bound(module) {
        let element = match module.types[global.ty].inner {
            TypeInner::Array { base, .. } => base,
            _ => global.ty,
        };
        let ty = &module.types[element];
        let TypeInner::Struct { members, span } = &ty.inner else {
            continue;
        };
        let name = ty.name.as_deref().unwrap();
        let fields = members
            .iter()
            .map(|member| {
                (
                    member.name.clone().unwrap(),
                    member.offset as usize,
                    scalar_name(&module.types[member.ty].inner),
                )
            })
            .collect();
        let wgsl: Layout = (fields, *span as usize);
        assert_eq!(rust.get(name), Some(&wgsl), "{name}");
        compared.insert(name);
    }
    assert!(compared.iter().eq(rust.keys()), "only {compared:?} were compared");
}

fn address_space(access: Access) -> AddressSpace {
    match access {
        Access::Uniform => AddressSpace::Uniform,
        Access::Read => AddressSpace::Storage {
            access: StorageAccess::LOAD,
        },
        Access::ReadWrite | Access::Kept => AddressSpace::Storage {
            access: StorageAccess::LOAD | StorageAccess::STORE,
        },
    }
}

/// The bindings are the host's: number, name and access of each.
pub fn assert_bindings(module: &Module, expected: &[Binding]) {
    let found: BTreeMap<_, _> = bound(module)
        .map(|(number, global)| (number, (global.name.as_deref().unwrap(), global.space)))
        .collect();
    assert_eq!(found.len(), bound(module).count(), "a number is bound twice");
    let expected = expected
        .iter()
        .map(|it| (it.number, (it.name, address_space(it.access))));
    assert_eq!(found, expected.collect());
}

/// Every `override` constant is set by the host for every kernel, and none besides; the kernels are the host's.
pub fn assert_constants_and_kernels(module: &Module, shader: &Shader) {
    let names: BTreeSet<_> = module
        .overrides
        .iter()
        .map(|(_, constant)| constant.name.as_deref().unwrap())
        .collect();
    for kernel in shader.kernels() {
        let set = shader.constants(kernel, WORKGROUP_SIZE);
        assert_eq!(names, set.iter().map(|(name, _)| *name).collect());
    }
    let entry_points: BTreeSet<_> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
    // some kernels differ in a constant alone
    assert_eq!(
        entry_points,
        shader.kernels().map(|kernel| shader.entry_point(kernel)).collect()
    );
}

/// Every kernel becomes SPIR-V, Metal's and DirectX's language.
pub fn assert_translates(module: &Module, info: &ModuleInfo, shader: &Shader) {
    for kernel in shader.kernels() {
        assert_kernel_translates(module, info, shader, kernel);
    }
}

fn assert_kernel_translates(module: &Module, info: &ModuleInfo, shader: &Shader, kernel: Kernel) {
    let name = shader.entry_point(kernel);
    let constants: PipelineConstants = shader
        .constants(kernel, WORKGROUP_SIZE)
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value))
        .collect();
    let entry = Some((ShaderStage::Compute, name));
    let (module, info) = pipeline_constants::process_overrides(module, info, entry, &constants).unwrap();
    let entry_point = (ShaderStage::Compute, name.to_owned());

    let options = spv::PipelineOptions {
        shader_stage: entry_point.0,
        entry_point: entry_point.1.clone(),
    };
    let words = spv::write_vec(&module, &info, &spv::Options::default(), Some(&options)).unwrap();
    assert_eq!(words[0], 0x0723_0203);

    let options = msl::PipelineOptions {
        entry_point: Some(entry_point.clone()),
        ..Default::default()
    };
    let (text, _) = msl::write_string(&module, &info, &msl::Options::default(), &options).unwrap();
    assert!(text.contains("kernel void"));

    let options = hlsl::PipelineOptions {
        entry_point: Some(entry_point),
    };
    let mut text = String::new();
    hlsl::Writer::new(&mut text, &hlsl::Options::default(), &options)
        .write(&module, &info, None)
        .unwrap();
    assert!(text.contains(&format!("numthreads({WORKGROUP_SIZE}, 1, 1)")));
}
