//! The header: what elements there are, and of what.

use crate::{ImportError, Place};

/// Longer headers are no headers.
const MAX_HEADER_BYTES: usize = 1 << 16;

/// How the body is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn of(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// In a binary file.
    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A number, or a list of them.
#[derive(Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Scalar,
    /// The type of a list's length.
    pub length: Option<Scalar>,
}

#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub format: Format,
    pub elements: Vec<Element>,
    /// Where the body begins.
    pub bytes: usize,
    /// Lines of it.
    pub lines: usize,
}

/// Reads what stands before the body.
pub(super) fn parse(file: &[u8], place: &Place) -> Result<Header, ImportError> {
    let mut header = Header { format: Format::Ascii, elements: Vec::new(), bytes: 0, lines: 0 };
    let mut format = None;
    loop {
        let rest = &file[header.bytes..file.len().min(MAX_HEADER_BYTES)];
        let at = || Place::new(&place.file, (header.lines + 1).to_string());
        let malformed = |problem: &str| ImportError::Malformed { place: at(), problem: problem.to_owned() };
        let Some(end) = rest.iter().position(|&b| b == b'\n') else {
            return Err(malformed("its PLY header has no end"));
        };
        let line = String::from_utf8_lossy(&rest[..end]);
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["ply"] if header.lines == 0 => {}
            _ if header.lines == 0 => return Err(malformed("it does not begin with \"ply\"")),
            ["format", name, _] => {
                format = Some(match name {
                    "ascii" => Format::Ascii,
                    "binary_little_endian" => Format::LittleEndian,
                    "binary_big_endian" => Format::BigEndian,
                    _ => {
                        return Err(malformed(
                            "a PLY file is ascii, binary_little_endian or binary_big_endian",
                        ));
                    }
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| malformed("a number of elements is expected"))?;
                header.elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref declaration @ ..] => {
                let property =
                    property(declaration).ok_or_else(|| malformed("no property that PLY knows"))?;
                let element = header.elements.last_mut();
                element.ok_or_else(|| malformed("a property of no element"))?.properties.push(property);
            }
            ["end_header"] => {
                header.format = format.ok_or_else(|| malformed("its PLY header names no format"))?;
                header.bytes += end + 1;
                header.lines += 1;
                return Ok(header);
            }
            [] | ["comment" | "obj_info", ..] => {}
            _ => return Err(malformed("no line that a PLY header has")),
        }
        header.bytes += end + 1;
        header.lines += 1;
    }
}

fn property(declaration: &[&str]) -> Option<Property> {
    match *declaration {
        ["list", length, kind, name] => {
            let (length, kind) = (Scalar::of(length)?, Scalar::of(kind)?);
            Some(Property { name: name.to_owned(), kind, length: Some(length) })
        }
        [kind, name] => Some(Property { name: name.to_owned(), kind: Scalar::of(kind)?, length: None }),
        _ => None,
    }
}
