//! The numbers after the header, one after the other.

use super::header::{Format, Scalar};

/// What is left of a body.
pub(super) struct Body<'a> {
    rest: &'a [u8],
    format: Format,
}

impl<'a> Body<'a> {
    pub fn new(bytes: &'a [u8], format: Format) -> Self {
        Self { rest: bytes, format }
    }

    /// Bytes left: no more numbers than these can come.
    pub fn len(&self) -> usize {
        self.rest.len()
    }

    /// The next number; none where the body ends or, as text, is no number.
    #[inline]
    pub fn next(&mut self, kind: Scalar) -> Option<f64> {
        match self.format {
            Format::Ascii => self.word()?.parse().ok(),
            Format::LittleEndian => self.binary(kind, false),
            Format::BigEndian => self.binary(kind, true),
        }
    }

    /// The next number as an index; what is none is the largest there is.
    #[inline]
    pub fn next_index(&mut self, kind: Scalar) -> Option<u32> {
        if let (Format::LittleEndian, Scalar::I32) = (self.format, kind) {
            let (bytes, rest) = self.rest.split_first_chunk()?;
            self.rest = rest;
            return Some(u32::try_from(i32::from_le_bytes(*bytes)).unwrap_or(u32::MAX));
        }
        let index = self.next(kind)?;
        Some(if index.fract() == 0.0 && index >= 0.0 { index as u32 } else { u32::MAX })
    }

    fn word(&mut self) -> Option<&'a str> {
        let start = self.rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let rest = &self.rest[start..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.rest = rest;
        std::str::from_utf8(word).ok()
    }

    #[inline]
    fn binary(&mut self, kind: Scalar, big: bool) -> Option<f64> {
        macro_rules! number {
            ($t:ty) => {{
                let (bytes, rest) = self.rest.split_first_chunk::<{ size_of::<$t>() }>()?;
                self.rest = rest;
                if big { <$t>::from_be_bytes(*bytes) } else { <$t>::from_le_bytes(*bytes) }.into()
            }};
        }
        Some(match kind {
            Scalar::I8 => number!(i8),
            Scalar::U8 => number!(u8),
            Scalar::I16 => number!(i16),
            Scalar::U16 => number!(u16),
            Scalar::I32 => number!(i32),
            Scalar::U32 => number!(u32),
            Scalar::F32 => number!(f32),
            Scalar::F64 => number!(f64),
        })
    }
}
