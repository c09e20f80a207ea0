//! Literals and constant expressions.

use naga::{Expression, Handle, Literal, Module, Span, TypeInner};

use super::{
    error::{Result, Unsupported},
    expression::Text,
    names::{Names, identifier},
    types::rust_type,
};

/// A literal with its type.
pub(super) fn literal(literal: Literal, span: Span) -> Result<Text> {
    Ok(match literal {
        Literal::Bool(value) => Text::atom(value.to_string()),
        Literal::U32(value) => Text::atom(format!("{value}u32")),
        Literal::I32(i32::MIN) => Text::atom("i32::MIN"),
        Literal::I32(value) => signed(value < 0, format!("{value}i32")),
        Literal::F32(value) if value.is_finite() => signed(value.is_sign_negative(), format!("{value:?}f32")),
        Literal::F32(value) => Text::atom(format!("f32::from_bits({:#010x})", value.to_bits())),
        _ => return Err(Unsupported::new("a literal that is not bool, i32, u32 or f32", span)),
    })
}

/// A minus sign binds less than a method call.
fn signed(negative: bool, code: String) -> Text {
    if negative { Text::compound(code) } else { Text::atom(code) }
}

/// A module-scope expression.
pub(super) fn constant(module: &Module, names: &Names, handle: Handle<Expression>) -> Result<Text> {
    let span = module.global_expressions.get_span(handle);
    let parts = |handles: &[Handle<Expression>]| -> Result<Vec<Text>> {
        handles.iter().map(|&part| constant(module, names, part)).collect()
    };
    match module.global_expressions[handle] {
        Expression::Literal(value) => literal(value, span),
        Expression::Constant(named) if module.constants[named].name.is_some() => {
            Ok(Text::atom(names.constant(named)))
        }
        Expression::Constant(unnamed) => constant(module, names, module.constants[unnamed].init),
        Expression::ZeroValue(ty) => {
            Ok(Text::atom(format!("rt::zero::<{}>()", rust_type(module, names, ty)?)))
        }
        Expression::Splat { size, value } => {
            Ok(Text::atom(format!("Vec{}::splat({})", size as u32, constant(module, names, value)?.code)))
        }
        Expression::Compose { ty, ref components } => {
            let flat: Vec<_> =
                naga::proc::flatten_compose(ty, components, &module.global_expressions, &module.types)
                    .collect();
            let scalars = matches!(module.types[ty].inner, TypeInner::Vector { .. });
            let parts = parts(if scalars { &flat } else { components })?;
            compose(module, names, ty, &parts).map_err(|unsupported| unsupported.or_at(span))
        }
        _ => Err(Unsupported::new("this constant expression", span)),
    }
}

/// A value of its parts: components of a vector, columns, elements, members.
pub(super) fn compose(
    module: &Module,
    names: &Names,
    ty: Handle<naga::Type>,
    parts: &[Text],
) -> Result<Text> {
    let codes: Vec<&str> = parts.iter().map(|part| part.code.as_str()).collect();
    let list = codes.join(", ");
    match module.types[ty].inner {
        TypeInner::Vector { size, .. } => Ok(Text::atom(format!("Vec{}::new({list})", size as u32))),
        TypeInner::Matrix { .. } => Ok(Text::atom(format!("Mat::new([{list}])"))),
        TypeInner::Array { .. } => Ok(Text::atom(format!("[{list}]"))),
        TypeInner::Struct { ref members, .. } => {
            let members: Vec<String> = members
                .iter()
                .zip(codes)
                .map(|(member, code)| {
                    let name = identifier(member.name.as_deref().unwrap_or_default());
                    if name == code { name } else { format!("{name}: {code}") }
                })
                .collect();
            let name = rust_type(module, names, ty)?;
            // Compound: a condition must not begin with a struct.
            Ok(Text::compound(format!("{name} {{ {} }}", members.join(", "))))
        }
        _ => Err(Unsupported::new("composing this type", Span::UNDEFINED)),
    }
}
