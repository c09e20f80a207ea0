//! Rust types for WGSL's.

use naga::{ArraySize, Handle, Module, PredeclaredType, Scalar, Type, TypeInner, VectorSize};

use super::{
    error::{Result, Unsupported},
    names::Names,
    reflect::scalar_type,
};

/// The names of a vector's components.
pub(super) const COMPONENTS: [&str; 4] = ["x", "y", "z", "w"];

/// Which `__*_result` struct a built-in function's result type is, if it is one.
pub(super) fn predeclared(module: &Module, ty: Handle<Type>) -> Option<PredeclaredType> {
    let types = &module.special_types.predeclared_types;
    types.iter().find_map(|(predeclared, handle)| (*handle == ty).then(|| predeclared.clone()))
}

/// Whether the type is one of the built-in functions' results.
pub(super) fn is_predeclared(module: &Module, ty: Handle<Type>) -> bool {
    predeclared(module, ty).is_some()
}

/// A type's Rust name as a value.
pub(super) fn rust_type(module: &Module, names: &Names, ty: Handle<Type>) -> Result<String> {
    let name = match (predeclared(module, ty), &module.types[ty].inner) {
        (Some(predeclared), _) => predeclared_type(predeclared),
        (None, TypeInner::Struct { .. }) => Ok(names.ty(ty).to_owned()),
        (None, &TypeInner::Array { base, size: ArraySize::Constant(count), .. }) => {
            rust_type(module, names, base).map(|element| format!("[{element}; {count}]"))
        }
        (None, inner) => plain_type(inner),
    };
    name.map_err(|unsupported| unsupported.or_at(module.types.get_span(ty)))
}

/// The Rust name of a type that refers to no other.
pub(super) fn plain_type(inner: &TypeInner) -> Result<String> {
    match *inner {
        TypeInner::Scalar(scalar) => rust_scalar(scalar),
        TypeInner::Vector { size, scalar } => vector(size, scalar),
        TypeInner::Matrix { columns, rows, scalar } => {
            Ok(format!("Mat<{}, {}>", vector(rows, scalar)?, columns as u32))
        }
        ref other => Err(Unsupported::new(type_construct(other), naga::Span::UNDEFINED)),
    }
}

/// A scalar's Rust name.
pub(super) fn rust_scalar(scalar: Scalar) -> Result<String> {
    let unsupported = || Unsupported::new(type_construct(&TypeInner::Scalar(scalar)), naga::Span::UNDEFINED);
    scalar_type(scalar).map(|scalar| scalar.to_string()).ok_or_else(unsupported)
}

fn vector(size: VectorSize, scalar: Scalar) -> Result<String> {
    Ok(format!("Vec{}<{}>", size as u32, rust_scalar(scalar)?))
}

fn predeclared_type(ty: PredeclaredType) -> Result<String> {
    let value = |size: Option<VectorSize>, scalar| match size {
        Some(size) => vector(size, scalar),
        None => rust_scalar(scalar),
    };
    Ok(match ty {
        PredeclaredType::AtomicCompareExchangeWeakResult(scalar) => {
            format!("rt::ExchangeResult<{}>", rust_scalar(scalar)?)
        }
        PredeclaredType::ModfResult { size, scalar } => format!("rt::ModfResult<{}>", value(size, scalar)?),
        PredeclaredType::FrexpResult { size, scalar } => {
            format!("rt::FrexpResult<{}, {}>", value(size, scalar)?, value(size, Scalar::I32)?)
        }
    })
}

/// What a type that kernels cannot have is called.
fn type_construct(inner: &TypeInner) -> String {
    match inner {
        TypeInner::Scalar(scalar) => format!("a {}-bit {:?} scalar", scalar.width * 8, scalar.kind),
        TypeInner::Atomic(_) => "an atomic outside storage".to_owned(),
        TypeInner::Array { .. } => "an array of no fixed size as a value".to_owned(),
        TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } => "this pointer".to_owned(),
        TypeInner::Image { .. } => "a texture".to_owned(),
        TypeInner::Sampler { .. } => "a sampler".to_owned(),
        TypeInner::AccelerationStructure { .. } | TypeInner::RayQuery { .. } => "a ray query".to_owned(),
        TypeInner::CooperativeMatrix { .. } => "a cooperative matrix".to_owned(),
        _ => "this type".to_owned(),
    }
}

/// Whether values of the type exist: it holds neither atomics nor a runtime-sized array.
pub(super) fn is_value(module: &Module, ty: Handle<Type>) -> bool {
    module.types[ty].inner.is_constructible(&module.types)
}

/// The alignment of a vector, which is also the distance in bytes of a matrix' columns.
pub(super) fn column_stride(rows: VectorSize) -> u32 {
    if rows == VectorSize::Bi { 8 } else { 16 }
}

/// WGSL's `AlignOf`.
pub(super) fn alignment(module: &Module, ty: Handle<Type>) -> u32 {
    match module.types[ty].inner {
        TypeInner::Vector { size, .. } | TypeInner::Matrix { rows: size, .. } => column_stride(size),
        TypeInner::Array { base, .. } => alignment(module, base),
        TypeInner::Struct { ref members, .. } => {
            members.iter().map(|member| alignment(module, member.ty)).max().unwrap_or(4)
        }
        _ => 4,
    }
}
