//! Places: what a WGSL pointer points to.

use naga::{AddressSpace, ArraySize, Expression, Handle, Type, TypeInner};

use super::{
    error::{Result, Unsupported},
    expression::Text,
    function::FunctionWriter,
    names::identifier,
    types::{COMPONENTS, column_stride, rust_scalar, rust_type},
};

/// A place that can be loaded from, stored to, or pointed at.
#[derive(Clone, Debug)]
pub(super) enum Place {
    /// A Rust place: a local or private variable, a uniform, or a part of one.
    Variable {
        /// The place; where it is a reference, what is behind it is meant.
        code: String,
        /// Whether `code` is a `&mut`.
        is_reference: bool,
    },
    /// A component, by a computed index, of the vector in a Rust place.
    Component {
        /// The vector.
        vector: String,
        /// The index.
        index: String,
    },
    /// A place in a storage buffer.
    Storage {
        /// The buffer, or a place in it.
        base: String,
        /// Whether `base` is the buffer itself.
        is_buffer: bool,
        /// The offset from `base` in bytes.
        offset: u32,
    },
}

impl Place {
    pub(super) fn variable(code: impl Into<String>) -> Self {
        Self::Variable { code: code.into(), is_reference: false }
    }

    fn part(code: &str, part: &str) -> Self {
        Self::variable(format!("{code}{part}"))
    }

    /// The runtime's `Place`.
    fn storage(base: &str, is_buffer: bool, offset: u32) -> String {
        if is_buffer || offset > 0 { format!("{base}.at({offset})") } else { base.to_owned() }
    }

    /// As a `&mut` argument.
    pub(super) fn reference(&self) -> Option<String> {
        match self {
            Self::Variable { code, is_reference: true } => Some(code.clone()),
            Self::Variable { code, is_reference: false } => Some(format!("&mut {code}")),
            Self::Component { .. } | Self::Storage { .. } => None,
        }
    }
}

impl FunctionWriter<'_> {
    /// The place that a pointer expression points to.
    pub(super) fn place(&self, pointer: Handle<Expression>) -> Result<Place> {
        match self.function.expressions[pointer] {
            Expression::LocalVariable(local) => Ok(Place::variable(&self.locals[&local])),
            Expression::FunctionArgument(index) => {
                let code = self.arguments[index as usize].code.clone();
                Ok(Place::Variable { code, is_reference: true })
            }
            Expression::GlobalVariable(global) => {
                let name = self.names.global(global);
                Ok(match self.module.global_variables[global].space {
                    AddressSpace::Private => Place::variable(format!("private.{name}")),
                    AddressSpace::Uniform => Place::variable(format!("globals.{name}")),
                    _ => Place::Storage { base: format!("globals.{name}"), is_buffer: true, offset: 0 },
                })
            }
            Expression::Access { base, index } => {
                let (place, index) = (self.place(base)?, self.value(index)?.code);
                Ok(element(place, &self.pointee(base), &index))
            }
            Expression::AccessIndex { base, index } => {
                let place = self.place(base)?;
                Ok(part(place, &self.pointee(base), index))
            }
            _ => Err(Unsupported::new("this pointer", self.function.expressions.get_span(pointer))),
        }
    }

    /// The type of what a pointer points to.
    pub(super) fn pointee(&self, pointer: Handle<Expression>) -> TypeInner {
        match *self.inner(pointer) {
            TypeInner::Pointer { base, .. } => self.module.types[base].inner.clone(),
            TypeInner::ValuePointer { size: Some(size), scalar, .. } => TypeInner::Vector { size, scalar },
            TypeInner::ValuePointer { size: None, scalar, .. } => TypeInner::Scalar(scalar),
            ref value => value.clone(),
        }
    }

    /// The value in a place.
    pub(super) fn load(&self, pointer: Handle<Expression>) -> Result<Text> {
        if let Expression::LocalVariable(local) = self.function.expressions[pointer]
            && let Some(operator) = self.logicals.get(&local)
        {
            return Ok(operator.clone());
        }
        let pointee = self.pointee(pointer);
        Ok(match self.place(pointer)? {
            Place::Variable { code, is_reference: false } => Text::atom(code),
            Place::Variable { code, is_reference: true } => Text::compound(format!("*{code}")),
            Place::Component { vector, index } => Text::atom(format!("{vector}.at({index})")),
            Place::Storage { base, is_buffer, offset } => {
                let place = Place::storage(&base, is_buffer, offset);
                match pointee {
                    TypeInner::Atomic(scalar) => {
                        Text::atom(format!("{place}.atomic::<{}>().load()", rust_scalar(scalar)?))
                    }
                    _ => Text::atom(format!("{place}.load::<{}>()", self.pointee_type(pointer)?)),
                }
            }
        })
    }

    /// The statement that stores a value in a place.
    pub(super) fn store(&self, pointer: Handle<Expression>, value: &Text) -> Result<String> {
        let value = &value.code;
        Ok(match self.place(pointer)? {
            Place::Variable { code, is_reference: false } => format!("{code} = {value};"),
            Place::Variable { code, is_reference: true } => format!("*{code} = {value};"),
            Place::Component { vector, index } => format!("*{vector}.at_mut({index}) = {value};"),
            Place::Storage { base, is_buffer, offset } => {
                let place = Place::storage(&base, is_buffer, offset);
                match self.pointee(pointer) {
                    TypeInner::Atomic(scalar) => {
                        format!("{place}.atomic::<{}>().store({value});", rust_scalar(scalar)?)
                    }
                    _ => format!("{place}.store({value});"),
                }
            }
        })
    }

    /// The atomic in a place.
    pub(super) fn atomic(&self, pointer: Handle<Expression>) -> Result<String> {
        match (self.place(pointer)?, self.pointee(pointer)) {
            (Place::Storage { base, is_buffer, offset }, TypeInner::Atomic(scalar)) => {
                let place = Place::storage(&base, is_buffer, offset);
                Ok(format!("{place}.atomic::<{}>()", rust_scalar(scalar)?))
            }
            _ => Err(Unsupported::new("an atomic outside storage", naga::Span::UNDEFINED)),
        }
    }

    pub(super) fn array_length(&self, array: Handle<Expression>) -> Result<Text> {
        match (self.place(array)?, self.pointee(array)) {
            (Place::Storage { base, is_buffer: true, offset }, TypeInner::Array { stride, .. }) => {
                Ok(Text::atom(format!("{base}.array_length({offset}, {stride})")))
            }
            _ => Err(Unsupported::new("the length of this array", naga::Span::UNDEFINED)),
        }
    }

    fn pointee_type(&self, pointer: Handle<Expression>) -> Result<String> {
        match *self.inner(pointer) {
            TypeInner::Pointer { base, .. } => rust_type(self.module, self.names, base),
            _ => super::types::plain_type(&self.pointee(pointer)),
        }
    }

    /// The type that a pointer argument points to.
    pub(super) fn argument_pointee(&self, ty: Handle<Type>) -> Option<Handle<Type>> {
        match self.module.types[ty].inner {
            TypeInner::Pointer { base, space: AddressSpace::Function | AddressSpace::Private } => Some(base),
            _ => None,
        }
    }
}

/// A member, or a part by a fixed index.
fn part(place: Place, of: &TypeInner, index: u32) -> Place {
    match (place, of) {
        (Place::Variable { code, .. }, TypeInner::Struct { members, .. }) => {
            let name = members[index as usize].name.as_deref().unwrap_or_default();
            Place::part(&code, &format!(".{}", identifier(name)))
        }
        (Place::Variable { code, .. }, TypeInner::Vector { .. }) => {
            Place::part(&code, &format!(".{}", COMPONENTS[index as usize]))
        }
        (Place::Variable { code, .. }, TypeInner::Matrix { .. }) => {
            Place::part(&code, &format!(".columns[{index}]"))
        }
        (Place::Variable { code, .. }, _) => Place::part(&code, &format!("[{index}]")),
        (storage @ Place::Storage { .. }, TypeInner::Array { size: ArraySize::Dynamic, .. }) => {
            // Whether there is such an element only the buffer knows.
            element(storage, of, &format!("{index}u32"))
        }
        (Place::Storage { base, is_buffer, offset }, of) => {
            Place::Storage { base, is_buffer, offset: offset + part_offset(of, index) }
        }
        (place @ Place::Component { .. }, _) => place,
    }
}

/// An element, column or component by a computed index.
fn element(place: Place, of: &TypeInner, index: &str) -> Place {
    match (place, of) {
        (Place::Variable { code, .. }, TypeInner::Array { size: ArraySize::Constant(count), .. }) => {
            Place::part(&code, &format!("[rt::index({index}, {count})]"))
        }
        (Place::Variable { code, .. }, TypeInner::Matrix { columns, .. }) => {
            Place::part(&code, &format!(".columns[rt::index({index}, {})]", *columns as u32))
        }
        (Place::Variable { code, .. }, _) => Place::Component { vector: code, index: index.to_owned() },
        (Place::Storage { base, offset, .. }, TypeInner::Array { size: ArraySize::Dynamic, stride, .. }) => {
            let base = format!("{base}.element({index}, {offset}, {stride})");
            Place::Storage { base, is_buffer: false, offset: 0 }
        }
        (Place::Storage { base, is_buffer, offset }, of) => {
            let (count, stride) = fixed_array(of);
            let array = Place::storage(&base, is_buffer, offset);
            let base = format!("{array}.element({index}, {count}, {stride})");
            Place::Storage { base, is_buffer: false, offset: 0 }
        }
        (place @ Place::Component { .. }, _) => place,
    }
}

/// The offset in bytes of a part by a fixed index.
fn part_offset(of: &TypeInner, index: u32) -> u32 {
    match of {
        TypeInner::Struct { members, .. } => members[index as usize].offset,
        TypeInner::Array { stride, .. } => index * stride,
        TypeInner::Matrix { rows, .. } => index * column_stride(*rows),
        _ => index * 4,
    }
}

/// How many elements there are, and their distance in bytes.
fn fixed_array(of: &TypeInner) -> (u32, u32) {
    match *of {
        TypeInner::Array { size: ArraySize::Constant(count), stride, .. } => (count.get(), stride),
        TypeInner::Matrix { columns, rows, .. } => (columns as u32, column_stride(rows)),
        TypeInner::Vector { size, .. } => (size as u32, 4),
        _ => (1, 4),
    }
}
