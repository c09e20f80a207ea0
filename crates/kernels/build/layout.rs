//! Rust structs and constants generated from the WGSL's reflection.

use std::{collections::BTreeMap, fmt::Write as _};

use wgsl_cpu::translate::{ScalarType, ScalarValue, StructInfo, TypeInfo};

/// Structs that lie in uniform buffers as they are; everything else is packed by hand as vec4.
const UNIFORM_STRUCTS: [&str; 2] = ["Camera", "Params"];

/// `#[repr(C)]` structs with explicit padding, and compile-time checks of every offset and size.
pub fn structs(all: &BTreeMap<String, StructInfo>) -> String {
    let mut text = String::new();
    for info in UNIFORM_STRUCTS.iter().filter_map(|name| all.get(*name)) {
        write_struct(&mut text, info);
    }
    text
}

fn write_struct(text: &mut String, info: &StructInfo) {
    let name = &info.name;
    let _ = writeln!(
        text,
        "/// `{name}` as the kernels lay it out; the WGSL says what its members mean.\n\
         #[repr(C)]\n#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\npub struct {name} {{"
    );
    let mut end = 0;
    for member in &info.members {
        pad(text, end, member.offset);
        let _ =
            writeln!(text, "    /// `{}`\n    pub {}: {},", member.ty, member.name, rust_type(&member.ty));
        end = member.offset + member.size;
    }
    pad(text, end, info.size);
    let _ = writeln!(text, "}}\nconst _: () = assert!(size_of::<{name}>() == {});", info.size);
    for member in &info.members {
        let _ = writeln!(
            text,
            "const _: () = assert!(std::mem::offset_of!({name}, {}) == {});",
            member.name, member.offset
        );
    }
}

fn pad(text: &mut String, from: u32, to: u32) {
    if to > from {
        let _ = writeln!(text, "    /// Padding.\n    pub pad_{from}: [u32; {}],", (to - from) / 4);
    }
}

fn rust_type(ty: &TypeInfo) -> String {
    match ty {
        TypeInfo::Scalar(scalar) => rust_scalar(*scalar).into(),
        TypeInfo::Vector { size, scalar } => format!("[{}; {size}]", rust_scalar(*scalar)),
        TypeInfo::Struct(name) => name.clone(),
        other => panic!("{other} has no place in a uniform buffer's host struct"),
    }
}

fn rust_scalar(scalar: ScalarType) -> &'static str {
    match scalar {
        ScalarType::U32 => "u32",
        ScalarType::I32 => "i32",
        ScalarType::F32 => "f32",
        ScalarType::Bool => panic!("a bool is in no buffer"),
    }
}

/// The kernels' scalar constants.
pub fn constants(all: &BTreeMap<String, ScalarValue>) -> String {
    let mut text = String::new();
    for (name, value) in all {
        let typed = match value {
            ScalarValue::U32(x) => format!("u32 = {x}"),
            ScalarValue::I32(x) => format!("i32 = {x}"),
            ScalarValue::F32(x) => format!("f32 = f32::from_bits({:#010x})", x.to_bits()),
            ScalarValue::Bool(x) => format!("bool = {x}"),
        };
        let _ = writeln!(text, "/// `{name}` of the kernels.\npub const {name}: {typed};");
    }
    text
}
