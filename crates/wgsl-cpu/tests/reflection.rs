//! What hosts learn about a module.

use wgsl_cpu::{
    BindingKind,
    translate::{ScalarValue, translate},
};

const WGSL: &str = include_str!("golden/kernel.wgsl");

#[test]
fn bindings_are_those_used_by_slot() {
    let translation = translate(WGSL).expect("valid");
    let bindings: Vec<_> = translation
        .bindings
        .iter()
        .map(|binding| {
            (binding.name.as_str(), binding.slot, binding.kind, binding.min_bytes, binding.ty.to_string())
        })
        .collect();
    assert_eq!(
        bindings,
        [
            ("params", 0, BindingKind::Uniform, 64, "Params".to_owned()),
            ("points", 1, BindingKind::StorageRead, 16, "array<vec4<f32>>".to_owned()),
            ("queue", 3, BindingKind::StorageReadWrite, 64, "Queue".to_owned()),
            ("texels", 4, BindingKind::Texels, 16, "(not in buffers)".to_owned()),
        ]
    );
    let entry = translation.entry.expect("an entry point");
    assert_eq!((entry.name.as_str(), entry.workgroup_size), ("kernel", 64));
    assert_eq!(entry.workgroup_override, None);
}

#[test]
fn a_workgroup_may_be_sized_by_an_override() {
    let translation =
        translate("override WIDE: u32 = 32u;\n@compute @workgroup_size(WIDE)\nfn main() {}").expect("valid");
    let entry = translation.entry.expect("an entry point");
    assert_eq!((entry.workgroup_size, entry.workgroup_override.as_deref()), (32, Some("WIDE")));
}

#[test]
fn structs_have_their_layout() {
    let translation = translate(WGSL).expect("valid");
    let layout: Vec<_> = translation
        .structs
        .iter()
        .flat_map(|structure| {
            structure.members.iter().map(|member| {
                let name = format!("{}.{}", structure.name, member.name);
                (name, member.offset, member.size, member.ty.to_string())
            })
        })
        .collect();
    let expected = [
        ("Params.count", 0, 4, "u32"),
        ("Params.scale", 16, 12, "vec3<f32>"),
        ("Params.weights", 32, 32, "array<vec4<f32>, 2>"),
        ("Item.position", 0, 12, "vec3<f32>"),
        ("Item.kind", 12, 4, "u32"),
        ("Item.samples", 16, 20, "array<f32, 5>"),
        ("Queue.length", 0, 4, "atomic<u32>"),
        ("Queue.peak", 4, 4, "atomic<i32>"),
        ("Queue.items", 16, 48, "array<Item>"),
    ];
    assert_eq!(
        layout,
        expected.map(|(name, offset, size, ty)| (name.to_owned(), offset, size, ty.to_owned()))
    );
    let sizes: Vec<_> = translation.structs.iter().map(|structure| structure.size).collect();
    assert_eq!(sizes, [64, 48, 64]);
}

#[test]
fn typed_constants_have_their_values() {
    let wgsl = "const A: f32 = 1.5; const B = 3u; const C: i32 = -4; const D: bool = true;
        const E = array<u32, 2>(1u, 2u); const F = A * 2.0; const G = f32();";
    let constants = translate(wgsl).expect("valid").constants;
    let values: Vec<_> = constants.iter().map(|constant| (constant.name.as_str(), constant.value)).collect();
    assert_eq!(
        values,
        [
            ("A", Some(ScalarValue::F32(1.5))),
            ("B", Some(ScalarValue::U32(3))),
            ("C", Some(ScalarValue::I32(-4))),
            ("D", Some(ScalarValue::Bool(true))),
            ("E", None),
            ("F", Some(ScalarValue::F32(3.0))),
            ("G", Some(ScalarValue::F32(0.0))),
        ]
    );
}

#[test]
fn names_that_rust_has_taken_get_an_underscore() {
    let wgsl = "struct Private { entry: f32, gen: u32 }
        fn dyn(Some: f32) -> Private { var Vec3 = Private(Some, 1u); return Vec3; }";
    let rust = translate(wgsl).expect("valid").rust;
    assert!(rust.contains("pub struct Private_ {"), "{rust}");
    assert!(rust.contains("pub gen_: u32"), "{rust}");
    assert!(rust.contains("pub fn dyn_(Some_: f32) -> Private_"), "{rust}");
}
