//! The runtime's names of WGSL's built-in functions.

use naga::MathFunction;

/// The runtime's function, if kernels may use it.
pub(super) fn runtime_function(function: MathFunction) -> Option<&'static str> {
    numeric(function)
        .or_else(|| geometric(function))
        .or_else(|| bitwise(function))
        .or_else(|| packing(function))
}

fn numeric(function: MathFunction) -> Option<&'static str> {
    Some(match function {
        MathFunction::Abs => "abs",
        MathFunction::Min => "min",
        MathFunction::Max => "max",
        MathFunction::Clamp => "clamp",
        MathFunction::Saturate => "saturate",
        MathFunction::Cos => "cos",
        MathFunction::Cosh => "cosh",
        MathFunction::Sin => "sin",
        MathFunction::Sinh => "sinh",
        MathFunction::Tan => "tan",
        MathFunction::Tanh => "tanh",
        MathFunction::Acos => "acos",
        MathFunction::Asin => "asin",
        MathFunction::Atan => "atan",
        MathFunction::Atan2 => "atan2",
        MathFunction::Asinh => "asinh",
        MathFunction::Acosh => "acosh",
        MathFunction::Atanh => "atanh",
        MathFunction::Radians => "radians",
        MathFunction::Degrees => "degrees",
        MathFunction::Ceil => "ceil",
        MathFunction::Floor => "floor",
        MathFunction::Round => "round",
        MathFunction::Fract => "fract",
        MathFunction::Trunc => "trunc",
        MathFunction::Modf => "modf",
        MathFunction::Frexp => "frexp",
        MathFunction::Ldexp => "ldexp",
        MathFunction::Exp => "exp",
        MathFunction::Exp2 => "exp2",
        MathFunction::Log => "log",
        MathFunction::Log2 => "log2",
        MathFunction::Pow => "pow",
        MathFunction::Sign => "sign",
        MathFunction::Fma => "fma",
        MathFunction::Mix => "mix",
        MathFunction::Step => "step",
        MathFunction::SmoothStep => "smoothstep",
        MathFunction::Sqrt => "sqrt",
        MathFunction::InverseSqrt => "inverse_sqrt",
        MathFunction::QuantizeToF16 => "quantize_to_f16",
        _ => return None,
    })
}

fn geometric(function: MathFunction) -> Option<&'static str> {
    Some(match function {
        MathFunction::Dot => "dot",
        MathFunction::Cross => "cross",
        MathFunction::Distance => "distance",
        MathFunction::Length => "length",
        MathFunction::Normalize => "normalize",
        MathFunction::FaceForward => "face_forward",
        MathFunction::Reflect => "reflect",
        MathFunction::Refract => "refract",
        MathFunction::Transpose => "transpose",
        MathFunction::Determinant => "determinant",
        _ => return None,
    })
}

fn bitwise(function: MathFunction) -> Option<&'static str> {
    Some(match function {
        MathFunction::CountTrailingZeros => "count_trailing_zeros",
        MathFunction::CountLeadingZeros => "count_leading_zeros",
        MathFunction::CountOneBits => "count_one_bits",
        MathFunction::ReverseBits => "reverse_bits",
        MathFunction::ExtractBits => "extract_bits",
        MathFunction::InsertBits => "insert_bits",
        MathFunction::FirstTrailingBit => "first_trailing_bit",
        MathFunction::FirstLeadingBit => "first_leading_bit",
        _ => return None,
    })
}

fn packing(function: MathFunction) -> Option<&'static str> {
    Some(match function {
        MathFunction::Pack4x8snorm => "pack4x8snorm",
        MathFunction::Pack4x8unorm => "pack4x8unorm",
        MathFunction::Pack2x16snorm => "pack2x16snorm",
        MathFunction::Pack2x16unorm => "pack2x16unorm",
        MathFunction::Pack2x16float => "pack2x16float",
        MathFunction::Pack4xI8 => "pack4x_i8",
        MathFunction::Pack4xU8 => "pack4x_u8",
        MathFunction::Pack4xI8Clamp => "pack4x_i8_clamp",
        MathFunction::Pack4xU8Clamp => "pack4x_u8_clamp",
        MathFunction::Unpack4x8snorm => "unpack4x8snorm",
        MathFunction::Unpack4x8unorm => "unpack4x8unorm",
        MathFunction::Unpack2x16snorm => "unpack2x16snorm",
        MathFunction::Unpack2x16unorm => "unpack2x16unorm",
        MathFunction::Unpack2x16float => "unpack2x16float",
        MathFunction::Unpack4xI8 => "unpack4x_i8",
        MathFunction::Unpack4xU8 => "unpack4x_u8",
        _ => return None,
    })
}
