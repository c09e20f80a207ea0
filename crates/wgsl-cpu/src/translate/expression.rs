//! Expressions as Rust.

use naga::{
    BinaryOperator, Expression, Handle, Literal, MathFunction, RelationalFunction, ScalarKind, TypeInner,
    UnaryOperator,
};

use super::{
    error::{Result, Unsupported},
    function::FunctionWriter,
    literal,
    math::runtime_function,
    names::identifier,
    types::{COMPONENTS, is_predeclared, rust_type},
};

/// A Rust expression, and whether it can stand before a method call or beside an operator.
#[derive(Clone, Debug)]
pub(super) struct Text {
    pub(super) code: String,
    is_atom: bool,
}

impl Text {
    pub(super) fn atom(code: impl Into<String>) -> Self {
        Self { code: code.into(), is_atom: true }
    }

    pub(super) fn compound(code: impl Into<String>) -> Self {
        Self { code: code.into(), is_atom: false }
    }

    /// In parentheses, if it needs them.
    pub(super) fn operand(&self) -> String {
        if self.is_atom { self.code.clone() } else { format!("({})", self.code) }
    }
}

impl FunctionWriter<'_> {
    /// The value of an expression: its name where it has one.
    pub(super) fn value(&self, handle: Handle<Expression>) -> Result<Text> {
        match self.values.get(&handle) {
            Some(text) => Ok(text.clone()),
            None => self.compute(handle),
        }
    }

    /// What computes an expression.
    pub(super) fn compute(&self, handle: Handle<Expression>) -> Result<Text> {
        let span = self.function.expressions.get_span(handle);
        self.render(handle).map_err(|unsupported| unsupported.or_at(span))
    }

    fn render(&self, handle: Handle<Expression>) -> Result<Text> {
        match self.function.expressions[handle] {
            Expression::Literal(value) => literal::literal(value, self.function.expressions.get_span(handle)),
            Expression::Constant(constant) => match self.module.constants[constant].name {
                Some(_) => Ok(Text::atom(self.names.constant(constant))),
                None => literal::constant(self.module, self.names, self.module.constants[constant].init),
            },
            Expression::Override(value) => match self.module.overrides[value].init {
                Some(default) => literal::constant(self.module, self.names, default),
                None => Err(Unsupported::new("a pipeline override without a default", naga::Span::UNDEFINED)),
            },
            Expression::ZeroValue(ty) => {
                Ok(Text::atom(format!("rt::zero::<{}>()", rust_type(self.module, self.names, ty)?)))
            }
            Expression::Compose { ty, ref components } => self.compose(ty, components),
            Expression::Access { base, index } => self.access(base, index),
            Expression::AccessIndex { base, index } => self.access_index(base, index),
            Expression::Splat { size, value } => {
                Ok(Text::atom(format!("Vec{}::splat({})", size as u32, self.value(value)?.code)))
            }
            Expression::Swizzle { size, .. } => {
                let components: Vec<_> =
                    self.components(handle, size)?.into_iter().map(|component| component.code).collect();
                Ok(Text::atom(format!("Vec{}::new({})", size as u32, components.join(", "))))
            }
            Expression::FunctionArgument(index) => Ok(self.arguments[index as usize].clone()),
            Expression::Load { pointer } => self.load(pointer),
            Expression::Unary { op, expr } => self.unary(op, expr),
            Expression::Binary { op, left, right } => self.binary(op, left, right),
            Expression::Select { condition, accept, reject } => self.select(condition, accept, reject),
            Expression::Relational { fun: RelationalFunction::All, argument } => {
                Ok(Text::atom(format!("rt::all({})", self.value(argument)?.code)))
            }
            Expression::Relational { fun: RelationalFunction::Any, argument } => {
                Ok(Text::atom(format!("rt::any({})", self.value(argument)?.code)))
            }
            Expression::Math { fun, arg, arg1, arg2, arg3 } => self.math(fun, [Some(arg), arg1, arg2, arg3]),
            Expression::As { expr, kind, convert } => self.cast(expr, kind, convert),
            Expression::ArrayLength(array) => self.array_length(array),
            Expression::ImageLoad { image, coordinate, array_index: Some(layer), .. } => {
                self.texel(image, coordinate, layer)
            }
            ref other => Err(Unsupported::new(construct(other), naga::Span::UNDEFINED)),
        }
    }

    /// `textureLoad` of a texel store, which has one level.
    fn texel(
        &self,
        image: Handle<Expression>,
        coordinate: Handle<Expression>,
        layer: Handle<Expression>,
    ) -> Result<Text> {
        let Expression::GlobalVariable(store) = self.function.expressions[image] else {
            return Err(Unsupported::new("a texture as an argument", naga::Span::UNDEFINED));
        };
        let (at, layer) = (self.value(coordinate)?.code, self.value(layer)?.code);
        Ok(Text::atom(format!("globals.{}.texel({at}, {layer})", self.names.global(store))))
    }

    fn compose(&self, ty: Handle<naga::Type>, components: &[Handle<Expression>]) -> Result<Text> {
        let is_vector = matches!(self.module.types[ty].inner, TypeInner::Vector { .. });
        let mut parts = Vec::new();
        for &component in components {
            match *self.inner(component) {
                TypeInner::Vector { size, .. } if is_vector => {
                    parts.extend(self.components(component, size)?)
                }
                _ => parts.push(self.value(component)?),
            }
        }
        literal::compose(self.module, self.names, ty, &parts)
    }

    /// The components of a vector one by one.
    fn components(&self, vector: Handle<Expression>, size: naga::VectorSize) -> Result<Vec<Text>> {
        let (vector, pattern) = match self.function.expressions[vector] {
            Expression::Swizzle { vector, pattern, .. } => (vector, pattern),
            _ => (vector, naga::SwizzleComponent::XYZW),
        };
        let vector = self.value(vector)?.operand();
        let names = pattern[..size as usize].iter().map(|&component| COMPONENTS[component as usize]);
        Ok(names.map(|name| Text::atom(format!("{vector}.{name}"))).collect())
    }

    /// A component, column or element of a value, by an index that is computed.
    fn access(&self, base: Handle<Expression>, index: Handle<Expression>) -> Result<Text> {
        let (value, at) = (self.value(base)?.operand(), self.value(index)?.code);
        Ok(Text::atom(match *self.inner(base) {
            TypeInner::Array { size: naga::ArraySize::Constant(count), .. } => {
                format!("{value}[rt::index({at}, {count})]")
            }
            _ => format!("{value}.at({at})"),
        }))
    }

    fn access_index(&self, base: Handle<Expression>, index: u32) -> Result<Text> {
        let value = self.value(base)?.operand();
        let part = match self.inner(base) {
            TypeInner::Struct { members, .. } => self.member(base, &members[index as usize], index),
            TypeInner::Vector { .. } => format!(".{}", COMPONENTS[index as usize]),
            TypeInner::Matrix { .. } => format!(".columns[{index}]"),
            _ => format!("[{index}]"),
        };
        Ok(Text::atom(value + &part))
    }

    fn member(&self, base: Handle<Expression>, member: &naga::StructMember, index: u32) -> String {
        let is_result = self.info[base].ty.handle().is_some_and(|ty| is_predeclared(self.module, ty));
        match (&member.name, is_result) {
            (Some(name), false) => format!(".{}", identifier(name)),
            // The runtime's result structs have WGSL's own member names.
            (Some(name), true) => format!(".{name}"),
            (None, _) => format!(".{index}"),
        }
    }

    fn unary(&self, op: UnaryOperator, operand: Handle<Expression>) -> Result<Text> {
        let value = self.value(operand)?.operand();
        let is_int =
            matches!(self.inner(operand), TypeInner::Scalar(scalar) if scalar.kind == ScalarKind::Sint);
        Ok(match op {
            UnaryOperator::Negate if is_int => Text::atom(format!("{value}.wrapping_neg()")),
            UnaryOperator::Negate => Text::compound(format!("-{value}")),
            UnaryOperator::LogicalNot | UnaryOperator::BitwiseNot => Text::compound(format!("!{value}")),
        })
    }

    fn binary(
        &self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Result<Text> {
        let (a, b) = (self.value(left)?, self.value(right)?);
        Ok(match (self.inner(left), self.inner(right)) {
            (TypeInner::Scalar(scalar), TypeInner::Scalar(_)) => match scalar.kind {
                ScalarKind::Sint | ScalarKind::Uint => int_binary(op, &a, &b, self.divides_safely(right)),
                _ => float_binary(op, &a, &b),
            },
            (TypeInner::Vector { .. }, TypeInner::Vector { .. }) => vector_binary(op, &a, &b),
            // A vector or matrix with a scalar, matrices: the runtime has the operators.
            _ => infix(op, &a, &b),
        })
    }

    /// Whether Rust's `/` and `%` by this integer are WGSL's: it is a literal but not 0 or -1.
    fn divides_safely(&self, divisor: Handle<Expression>) -> bool {
        match self.function.expressions[divisor] {
            Expression::Literal(Literal::U32(value)) => value != 0,
            Expression::Literal(Literal::I32(value)) => value != 0 && value != -1,
            _ => false,
        }
    }

    fn select(
        &self,
        condition: Handle<Expression>,
        accept: Handle<Expression>,
        reject: Handle<Expression>,
    ) -> Result<Text> {
        let (condition_is, accept, reject) =
            (self.value(condition)?, self.value(accept)?, self.value(reject)?);
        Ok(match self.inner(condition) {
            TypeInner::Scalar(_) => Text::compound(format!(
                "if {} {{ {} }} else {{ {} }}",
                condition_is.code, accept.code, reject.code
            )),
            _ => Text::atom(format!("rt::select({}, {}, {})", reject.code, accept.code, condition_is.code)),
        })
    }

    fn math(&self, function: MathFunction, operands: [Option<Handle<Expression>>; 4]) -> Result<Text> {
        let name = runtime_function(function)
            .ok_or_else(|| Unsupported::new(format!("the function {function:?}"), naga::Span::UNDEFINED))?;
        let operands: Vec<_> = operands.into_iter().flatten().collect();
        let mut codes =
            operands.iter().map(|&operand| Ok(self.value(operand)?.code)).collect::<Result<Vec<_>>>()?;
        if function == MathFunction::Mix
            && let (&TypeInner::Vector { size, .. }, TypeInner::Scalar(_)) =
                (self.inner(operands[0]), self.inner(operands[2]))
        {
            codes[2] = format!("Vec{}::splat({})", size as u32, codes[2]);
        }
        Ok(Text::atom(format!("rt::{name}({})", codes.join(", "))))
    }

    fn cast(&self, operand: Handle<Expression>, kind: ScalarKind, convert: Option<u8>) -> Result<Text> {
        let value = self.value(operand)?;
        let inner = self.inner(operand);
        let from = inner.scalar_kind();
        let to = match kind {
            ScalarKind::Float => "f32",
            ScalarKind::Sint => "i32",
            ScalarKind::Uint => "u32",
            ScalarKind::Bool => "bool",
            ScalarKind::AbstractInt | ScalarKind::AbstractFloat => {
                return Err(Unsupported::new("an abstract number", naga::Span::UNDEFINED));
            }
        };
        let is_int = |kind| matches!(kind, ScalarKind::Sint | ScalarKind::Uint);
        let is_scalar = matches!(inner, TypeInner::Scalar(_));
        Ok(match convert {
            _ if from == Some(kind) => value,
            // Between integers both are the same; `as` is also what makes floats of integers.
            _ if is_scalar && from.is_some_and(is_int) && is_int(kind) => {
                Text::compound(format!("{} as {to}", value.operand()))
            }
            Some(_) if is_scalar && from.is_some_and(is_int) && kind == ScalarKind::Float => {
                Text::compound(format!("{} as {to}", value.operand()))
            }
            Some(_) => Text::atom(format!("rt::to_{to}({})", value.code)),
            None => Text::atom(format!("rt::bitcast_{to}({})", value.code)),
        })
    }
}

/// The operator as Rust writes it.
fn symbol(op: BinaryOperator) -> &'static str {
    match op {
        BinaryOperator::Add => "+",
        BinaryOperator::Subtract => "-",
        BinaryOperator::Multiply => "*",
        BinaryOperator::Divide => "/",
        BinaryOperator::Modulo => "%",
        BinaryOperator::Equal => "==",
        BinaryOperator::NotEqual => "!=",
        BinaryOperator::Less => "<",
        BinaryOperator::LessEqual => "<=",
        BinaryOperator::Greater => ">",
        BinaryOperator::GreaterEqual => ">=",
        BinaryOperator::And => "&",
        BinaryOperator::ExclusiveOr => "^",
        BinaryOperator::InclusiveOr => "|",
        BinaryOperator::LogicalAnd => "&&",
        BinaryOperator::LogicalOr => "||",
        BinaryOperator::ShiftLeft => "<<",
        BinaryOperator::ShiftRight => ">>",
    }
}

fn infix(op: BinaryOperator, a: &Text, b: &Text) -> Text {
    Text::compound(format!("{} {} {}", a.operand(), symbol(op), b.operand()))
}

fn method(a: &Text, name: &str, b: &Text) -> Text {
    Text::atom(format!("{}.{name}({})", a.operand(), b.code))
}

fn runtime(name: &str, a: &Text, b: &Text) -> Text {
    Text::atom(format!("rt::{name}({}, {})", a.code, b.code))
}

/// Operators of two integers: nothing may overflow, trap or shift out.
fn int_binary(op: BinaryOperator, a: &Text, b: &Text, divides_safely: bool) -> Text {
    match op {
        BinaryOperator::Add => method(a, "wrapping_add", b),
        BinaryOperator::Subtract => method(a, "wrapping_sub", b),
        BinaryOperator::Multiply => method(a, "wrapping_mul", b),
        BinaryOperator::Divide if !divides_safely => runtime("div", a, b),
        BinaryOperator::Modulo if !divides_safely => runtime("rem", a, b),
        BinaryOperator::ShiftLeft => method(a, "wrapping_shl", b),
        BinaryOperator::ShiftRight => method(a, "wrapping_shr", b),
        _ => infix(op, a, b),
    }
}

/// Operators of two floats or bools.
fn float_binary(op: BinaryOperator, a: &Text, b: &Text) -> Text {
    match op {
        BinaryOperator::Modulo => runtime("rem", a, b),
        _ => infix(op, a, b),
    }
}

/// Operators of two vectors.
fn vector_binary(op: BinaryOperator, a: &Text, b: &Text) -> Text {
    match op {
        BinaryOperator::Equal => runtime("equal", a, b),
        BinaryOperator::NotEqual => runtime("not_equal", a, b),
        BinaryOperator::Less => runtime("less", a, b),
        BinaryOperator::LessEqual => runtime("less_equal", a, b),
        BinaryOperator::Greater => runtime("greater", a, b),
        BinaryOperator::GreaterEqual => runtime("greater_equal", a, b),
        BinaryOperator::ShiftLeft => runtime("shift_left", a, b),
        BinaryOperator::ShiftRight => runtime("shift_right", a, b),
        _ => infix(op, a, b),
    }
}

/// What an expression that kernels cannot have is called.
fn construct(expression: &Expression) -> &'static str {
    match expression {
        Expression::ImageSample { .. } | Expression::ImageLoad { .. } | Expression::ImageQuery { .. } => {
            "a texture"
        }
        Expression::Derivative { .. } => "a derivative",
        Expression::WorkGroupUniformLoadResult { .. } => "workgroup memory",
        Expression::SubgroupBallotResult | Expression::SubgroupOperationResult { .. } => {
            "a subgroup operation"
        }
        _ => "this expression",
    }
}
