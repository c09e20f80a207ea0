//! What a host needs to know about a module: buffers, layouts, constants.

use std::fmt;

use naga::{ArraySize, Handle, Literal, Module, ScalarKind, Type, TypeInner};

use crate::runtime::BindingKind;

/// A scalar type that buffers and constants may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ScalarType {
    /// `bool`, never in a buffer.
    Bool,
    /// `i32`.
    I32,
    /// `u32`.
    U32,
    /// `f32`.
    F32,
}

/// A type, as WGSL writes it (by `Display`) and lays it out.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum TypeInfo {
    /// A scalar.
    Scalar(ScalarType),
    /// `vecN<T>`.
    Vector {
        /// 2, 3 or 4.
        size: u32,
        /// The components' type.
        scalar: ScalarType,
    },
    /// `matCxR<f32>`.
    Matrix {
        /// 2, 3 or 4.
        columns: u32,
        /// 2, 3 or 4.
        rows: u32,
    },
    /// `atomic<T>`.
    Atomic(ScalarType),
    /// `array<T, N>` or `array<T>`.
    Array {
        /// The elements' type.
        element: Box<TypeInfo>,
        /// How many, if that is fixed.
        count: Option<u32>,
        /// The distance of two elements in bytes.
        stride: u32,
    },
    /// A struct, by its name in [`Translation::structs`](super::Translation::structs).
    Struct(String),
    /// A texel store, or a type that no buffer can hold.
    Other,
}

/// A struct's layout in buffers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StructInfo {
    /// Its WGSL name.
    pub name: String,
    /// Its size in bytes, padding at the end included; a runtime-sized array counts one element.
    pub size: u32,
    /// Its members in order.
    pub members: Vec<MemberInfo>,
}

/// A member of a struct.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemberInfo {
    /// Its WGSL name.
    pub name: String,
    /// Its offset in bytes.
    pub offset: u32,
    /// Its size in bytes, padding after it not included.
    pub size: u32,
    /// Its type.
    pub ty: TypeInfo,
}

/// A buffer that the module uses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BindingInfo {
    /// The WGSL variable's name.
    pub name: String,
    /// The WGSL `@binding`; the group is 0.
    pub slot: u32,
    /// Its address space and access.
    pub kind: BindingKind,
    /// The least size in bytes (one element of a runtime-sized array).
    pub min_bytes: u64,
    /// Its type.
    pub ty: TypeInfo,
}

/// A module constant.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantInfo {
    /// Its WGSL name.
    pub name: String,
    /// Its type.
    pub ty: TypeInfo,
    /// Its value, if it is a scalar.
    pub value: Option<ScalarValue>,
}

/// The value of a scalar constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScalarValue {
    /// A `bool`.
    Bool(bool),
    /// An `i32`.
    I32(i32),
    /// A `u32`.
    U32(u32),
    /// An `f32`.
    F32(f32),
}

/// The entry point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryInfo {
    /// Its WGSL name.
    pub name: String,
    /// Invocations per workgroup along x; 1 along y and z. The default, where an override says how many.
    pub workgroup_size: u32,
    /// The name of that override.
    pub workgroup_override: Option<String>,
}

impl fmt::Display for ScalarType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bool => "bool",
            Self::I32 => "i32",
            Self::U32 => "u32",
            Self::F32 => "f32",
        })
    }
}

impl fmt::Display for TypeInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scalar(scalar) => write!(f, "{scalar}"),
            Self::Vector { size, scalar } => write!(f, "vec{size}<{scalar}>"),
            Self::Matrix { columns, rows } => write!(f, "mat{columns}x{rows}<f32>"),
            Self::Atomic(scalar) => write!(f, "atomic<{scalar}>"),
            Self::Array { element, count: Some(count), .. } => write!(f, "array<{element}, {count}>"),
            Self::Array { element, count: None, .. } => write!(f, "array<{element}>"),
            Self::Struct(name) => f.write_str(name),
            Self::Other => f.write_str("(not in buffers)"),
        }
    }
}

/// The scalar type, unless it is one that kernels must not use.
pub(super) fn scalar_type(scalar: naga::Scalar) -> Option<ScalarType> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => Some(ScalarType::Bool),
        (ScalarKind::Sint, 4) => Some(ScalarType::I32),
        (ScalarKind::Uint, 4) => Some(ScalarType::U32),
        (ScalarKind::Float, 4) => Some(ScalarType::F32),
        _ => None,
    }
}

/// Describes a type of the module.
pub(super) fn type_info(module: &Module, ty: Handle<Type>) -> TypeInfo {
    match module.types[ty].inner {
        TypeInner::Scalar(scalar) => scalar_type(scalar).map_or(TypeInfo::Other, TypeInfo::Scalar),
        TypeInner::Atomic(scalar) => scalar_type(scalar).map_or(TypeInfo::Other, TypeInfo::Atomic),
        TypeInner::Vector { size, scalar } => scalar_type(scalar)
            .map_or(TypeInfo::Other, |scalar| TypeInfo::Vector { size: size as u32, scalar }),
        TypeInner::Matrix { columns, rows, .. } => {
            TypeInfo::Matrix { columns: columns as u32, rows: rows as u32 }
        }
        TypeInner::Array { base, size, stride } => {
            let count = match size {
                ArraySize::Constant(count) => Some(count.get()),
                ArraySize::Pending(_) | ArraySize::Dynamic => None,
            };
            TypeInfo::Array { element: Box::new(type_info(module, base)), count, stride }
        }
        TypeInner::Struct { .. } => TypeInfo::Struct(module.types[ty].name.clone().unwrap_or_default()),
        _ => TypeInfo::Other,
    }
}

/// Describes all structs that the source declares.
pub(super) fn structs(module: &Module) -> Vec<StructInfo> {
    let declared = module.types.iter().filter(|(ty, _)| !super::types::is_predeclared(module, *ty));
    declared
        .filter_map(|(_, ty)| match (&ty.name, &ty.inner) {
            (Some(name), TypeInner::Struct { members, span }) => Some(StructInfo {
                name: name.clone(),
                size: *span,
                members: members.iter().map(|member| member_info(module, member)).collect(),
            }),
            _ => None,
        })
        .collect()
}

fn member_info(module: &Module, member: &naga::StructMember) -> MemberInfo {
    MemberInfo {
        name: member.name.clone().unwrap_or_default(),
        offset: member.offset,
        size: module.types[member.ty].inner.size(module.to_ctx()),
        ty: type_info(module, member.ty),
    }
}

/// Describes all named constants.
pub(super) fn constants(module: &Module) -> Vec<ConstantInfo> {
    let named = module.constants.iter().filter_map(|(_, constant)| Some((constant.name.clone()?, constant)));
    named
        .map(|(name, constant)| ConstantInfo {
            name,
            ty: type_info(module, constant.ty),
            value: scalar_value(module, constant.init),
        })
        .collect()
}

fn scalar_value(module: &Module, expression: Handle<naga::Expression>) -> Option<ScalarValue> {
    match module.global_expressions[expression] {
        naga::Expression::Literal(Literal::Bool(value)) => Some(ScalarValue::Bool(value)),
        naga::Expression::Literal(Literal::I32(value)) => Some(ScalarValue::I32(value)),
        naga::Expression::Literal(Literal::U32(value)) => Some(ScalarValue::U32(value)),
        naga::Expression::Literal(Literal::F32(value)) => Some(ScalarValue::F32(value)),
        naga::Expression::Constant(constant) => scalar_value(module, module.constants[constant].init),
        naga::Expression::ZeroValue(ty) => match module.types[ty].inner {
            TypeInner::Scalar(scalar) => scalar_type(scalar).map(|scalar| match scalar {
                ScalarType::Bool => ScalarValue::Bool(false),
                ScalarType::I32 => ScalarValue::I32(0),
                ScalarType::U32 => ScalarValue::U32(0),
                ScalarType::F32 => ScalarValue::F32(0.0),
            }),
            _ => None,
        },
        _ => None,
    }
}
