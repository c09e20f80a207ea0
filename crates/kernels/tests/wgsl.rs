//! Every kernel's linked WGSL is valid, and keeps to what runs on a GPU, on the CPU and in a
//! browser alike: no barriers, no workgroup memory, few storage buffers, one group.

use std::collections::{BTreeMap, HashSet};

use midway_kernels::{KERNELS, constants, kernel};
use naga::{
    AddressSpace, Block, GlobalVariable, Handle, Module, ShaderStage, Statement, StorageAccess,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};
use wgsl_cpu::BindingKind;

/// Storage buffers of one stage that every WebGPU device takes.
const MAX_STORAGE_BUFFERS: usize = 8;
/// Uniform buffers are at most this large on every WebGPU device, in bytes.
const MAX_UNIFORM_BYTES: u64 = 65_536;

/// A linked kernel, parsed and validated without any capability that a browser may lack.
fn validated(name: &str, wgsl: &str) -> Result<(Module, ModuleInfo), String> {
    let module =
        naga::front::wgsl::parse_str(wgsl).map_err(|e| format!("{name}: {}", e.emit_to_string(wgsl)))?;
    // Halves in buffers (unpack2x16float) are WGSL's own; their arithmetic would be an extension.
    let info = Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32)
        .validate(&module)
        .map_err(|e| format!("{name}: {}", e.emit_to_string(wgsl)))?;
    Ok((module, info))
}

/// Two features with one bit would be taken for each other.
#[test]
fn features_are_bits_of_their_own() {
    let text = include_str!("../wgsl/lib/features.wgsl");
    let values = text.lines().filter(|line| line.starts_with("const FEATURE_")).map(|line| {
        let value = line.rsplit("= ").next().and_then(|value| value.strip_suffix("u;"));
        value.and_then(|value| value.parse::<u32>().ok()).unwrap_or_else(|| panic!("{line}"))
    });
    let mut seen = 0;
    for value in values {
        assert!(value.is_power_of_two() && seen & value == 0, "{value}");
        seen |= value;
    }
    assert_ne!(seen, 0);
}

/// All kernels with their modules.
fn modules() -> Vec<(&'static wgsl_cpu::Kernel, Module, ModuleInfo)> {
    let parsed = KERNELS.iter().map(|kernel| {
        let (module, info) = validated(kernel.name, kernel.wgsl).unwrap_or_else(|error| panic!("{error}"));
        (kernel, module, info)
    });
    parsed.collect()
}

/// The buffers that a module's entry point reaches, by name.
fn reached<'a>(module: &'a Module, info: &ModuleInfo) -> Vec<(Handle<GlobalVariable>, &'a GlobalVariable)> {
    let uses = info.get_entry_point(0);
    module.global_variables.iter().filter(|(handle, _)| !uses[*handle].is_empty()).collect()
}

#[test]
fn every_kernel_is_valid_and_has_one_entry_point_of_its_name() {
    assert!(KERNELS.len() >= 15, "{} kernels are too few to be all", KERNELS.len());
    for (kernel, module, _) in modules() {
        let [entry] = &module.entry_points[..] else { panic!("{}: not one entry point", kernel.name) };
        assert_eq!(entry.name, kernel.name);
        assert_eq!(entry.stage, ShaderStage::Compute);
        assert_eq!(kernel.workgroup_size, constants::WORKGROUP, "{}", kernel.name);
        // Those whose grids are written by SHADE_WORKGROUP, or counted by their own size.
        let shades = ["shade_camera", "shade_light", "connect", "connect_camera", "connect_ends"];
        let expected = shades.contains(&kernel.name).then_some("SHADE_WORKGROUP");
        assert_eq!(kernel.workgroup_override, expected, "{}", kernel.name);
    }
}

#[test]
fn names_are_unique_and_looked_up() {
    let names: HashSet<_> = KERNELS.iter().map(|kernel| kernel.name).collect();
    assert_eq!(names.len(), KERNELS.len());
    for k in KERNELS {
        assert!(std::ptr::eq(kernel(k.name), k));
    }
}

#[test]
fn no_kernel_synchronises() {
    for (kernel, module, _) in modules() {
        let bodies = module.functions.iter().map(|(_, function)| function);
        for function in bodies.chain(module.entry_points.iter().map(|entry| &entry.function)) {
            let found = forbidden(&function.body);
            assert!(found.is_none(), "{}: {:?}: {found:?}", kernel.name, function.name);
        }
        for (_, variable) in module.global_variables.iter() {
            // A handle is the texel store: the record of bindings knows no other.
            let allowed = matches!(
                variable.space,
                AddressSpace::Uniform | AddressSpace::Storage { .. } | AddressSpace::Handle
            );
            assert!(allowed, "{}: {:?} is in {:?}", kernel.name, variable.name, variable.space);
        }
    }
}

/// The first statement that the CPU device or a browser has no place for.
fn forbidden(block: &Block) -> Option<&'static str> {
    block.iter().find_map(|statement| match statement {
        Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => Some("a barrier"),
        Statement::WorkGroupUniformLoad { .. } => Some("workgroup memory"),
        Statement::SubgroupBallot { .. }
        | Statement::SubgroupGather { .. }
        | Statement::SubgroupCollectiveOperation { .. } => Some("a subgroup operation"),
        Statement::RayQuery { .. } | Statement::RayPipelineFunction(_) => Some("a ray query"),
        Statement::Block(block) => forbidden(block),
        Statement::If { accept, reject, .. } => forbidden(accept).or_else(|| forbidden(reject)),
        Statement::Switch { cases, .. } => cases.iter().find_map(|case| forbidden(&case.body)),
        Statement::Loop { body, continuing, .. } => forbidden(body).or_else(|| forbidden(continuing)),
        _ => None,
    })
}

#[test]
fn buffers_are_few_and_in_group_0() {
    for (kernel, module, info) in modules() {
        let buffers = reached(&module, &info);
        let storage = buffers.iter().filter(|(_, v)| matches!(v.space, AddressSpace::Storage { .. })).count();
        assert!(storage <= MAX_STORAGE_BUFFERS, "{}: {storage} storage buffers", kernel.name);
        for (_, variable) in buffers {
            let place = variable.binding.as_ref().expect("a buffer is bound");
            assert_eq!(place.group, 0, "{}: {:?}", kernel.name, variable.name);
        }
    }
}

#[test]
fn the_record_of_bindings_is_the_modules() {
    for (kernel, module, info) in modules() {
        let mut expected: Vec<(u32, String, BindingKind)> = reached(&module, &info)
            .into_iter()
            .map(|(_, variable)| {
                let slot = variable.binding.as_ref().expect("bound").binding;
                (slot, variable.name.clone().expect("named"), kind(variable.space))
            })
            .collect();
        expected.sort_by_key(|(slot, ..)| *slot);
        let actual: Vec<_> = kernel.bindings.iter().map(|b| (b.slot, b.name.to_owned(), b.kind)).collect();
        assert_eq!(actual, expected, "{}", kernel.name);
        for binding in kernel.bindings {
            assert!(binding.min_bytes > 0, "{}: {}", kernel.name, binding.name);
            let fits = binding.kind != BindingKind::Uniform || binding.min_bytes <= MAX_UNIFORM_BYTES;
            assert!(fits, "{}: {} takes {} bytes", kernel.name, binding.name, binding.min_bytes);
        }
    }
}

fn kind(space: AddressSpace) -> BindingKind {
    match space {
        AddressSpace::Uniform => BindingKind::Uniform,
        AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => {
            BindingKind::StorageReadWrite
        }
        AddressSpace::Storage { .. } => BindingKind::StorageRead,
        AddressSpace::Handle => BindingKind::Texels,
        other => panic!("{other:?} is no buffer"),
    }
}

/// Hosts bind by name: a name is one slot, one slot is one name, and a buffer is of one usage.
#[test]
fn a_buffer_is_the_same_in_all_kernels() {
    let mut slots: BTreeMap<&str, (u32, BindingKind, &str)> = BTreeMap::new();
    let mut names: BTreeMap<u32, &str> = BTreeMap::new();
    for kernel in KERNELS {
        for binding in kernel.bindings {
            let (slot, kind, first) =
                *slots.entry(binding.name).or_insert((binding.slot, binding.kind, kernel.name));
            assert_eq!(slot, binding.slot, "{} in {} and {first}", binding.name, kernel.name);
            let uniform = [kind, binding.kind].map(|kind| kind == BindingKind::Uniform);
            assert_eq!(uniform[0], uniform[1], "{} in {} and {first}", binding.name, kernel.name);
            let name = *names.entry(binding.slot).or_insert(binding.name);
            assert_eq!(name, binding.name, "slot {slot}");
        }
    }
}

/// Probes are how a GPU's functions are compared with the CPU's: what kernels use of `lib/`, they
/// reach.
#[test]
fn probes_reach_every_library_function_that_kernels_use() {
    let (mut used, mut probed, mut library) = (HashSet::new(), HashSet::new(), HashSet::new());
    for (kernel, module, _) in modules() {
        let called = called_functions(&module);
        if kernel.name.starts_with("probe_") {
            probed.extend(called);
        } else {
            used.extend(called);
        }
        if kernel.name == "probe_math" {
            // Its module is the library and what all probes share.
            library = module.functions.iter().filter_map(|(_, function)| function.name.clone()).collect();
        }
    }
    let mut missing: Vec<_> = used.intersection(&library).filter(|name| !probed.contains(*name)).collect();
    missing.sort();
    assert!(used.len() >= 40 && library.len() >= 40, "{} used, {} there", used.len(), library.len());
    assert!(missing.is_empty(), "no probe calls {missing:?}");
}

/// The functions that a module's entry point calls, directly or not.
fn called_functions(module: &Module) -> HashSet<String> {
    let mut called = HashSet::new();
    let mut waiting = Vec::new();
    calls(&module.entry_points[0].function.body, &mut waiting);
    while let Some(handle) = waiting.pop() {
        let function = &module.functions[handle];
        if called.insert(function.name.clone().expect("named")) {
            calls(&function.body, &mut waiting);
        }
    }
    called
}

fn calls(block: &Block, found: &mut Vec<Handle<naga::Function>>) {
    for statement in block {
        match statement {
            Statement::Call { function, .. } => found.push(*function),
            Statement::Block(block) => calls(block, found),
            Statement::If { accept, reject, .. } => {
                [accept, reject].into_iter().for_each(|b| calls(b, found))
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| calls(&case.body, found)),
            Statement::Loop { body, continuing, .. } => {
                [body, continuing].into_iter().for_each(|b| calls(b, found));
            }
            _ => {}
        }
    }
}

/// The checks themselves find what they are to find.
#[test]
fn what_breaks_the_rules_is_found() {
    let text = "var<workgroup> shared_sum: atomic<u32>;
        @group(0) @binding(0) var<storage, read_write> out: array<u32>;
        @compute @workgroup_size(64) fn main(@builtin(local_invocation_index) i: u32) {
            if (out[0] == 0u) { atomicAdd(&shared_sum, 1u); }
            workgroupBarrier();
            out[i] = atomicLoad(&shared_sum);
        }";
    let (module, info) = validated("rule breaker", text).expect("valid, if against the rules");
    assert_eq!(forbidden(&module.entry_points[0].function.body), Some("a barrier"));
    assert_eq!(reached(&module, &info).len(), 2);
    assert!(validated("nonsense", "fn f() -> u32 { return 1.5; }").is_err());
}
