//! JSON values that know where they are.

use std::path::Path;

use serde_json::Value;

use super::file_place;
use crate::{ImportError, Place};

/// Parses a document; nesting is bounded by the parser.
pub(super) fn parse(path: &Path, text: &[u8]) -> Result<Value, ImportError> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    serde_json::from_slice(text).map_err(|e| ImportError::Malformed {
        place: file_place(path),
        problem: format!("its JSON does not parse ({e})"),
    })
}

/// A key as JSON pointers write it (RFC 6901), on one line.
pub(super) fn escaped(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1").replace(char::is_control, "?")
}

/// A value and its pointer.
#[derive(Clone)]
pub(super) struct Json<'a> {
    file: &'a Path,
    pointer: String,
    value: &'a Value,
}

impl<'a> Json<'a> {
    pub fn root(file: &'a Path, value: &'a Value) -> Self {
        Self { file, pointer: String::new(), value }
    }

    pub fn place(&self) -> Place {
        Place::new(self.file, self.pointer.clone())
    }

    pub fn pointer(&self) -> &str {
        &self.pointer
    }

    pub fn malformed(&self, problem: impl Into<String>) -> ImportError {
        ImportError::Malformed { place: self.place(), problem: problem.into() }
    }

    fn child(&self, key: &str, value: &'a Value) -> Self {
        Self { file: self.file, pointer: format!("{}/{}", self.pointer, escaped(key)), value }
    }

    /// A member of an object; none where it is absent, or where this is no object.
    pub fn get(&self, key: &str) -> Option<Self> {
        self.value.get(key).map(|value| self.child(key, value))
    }

    pub fn required(&self, key: &str) -> Result<Self, ImportError> {
        if !self.value.is_object() {
            return Err(self.malformed("an object is expected here"));
        }
        self.get(key).ok_or_else(|| self.malformed(format!("\"{key}\" is missing")))
    }

    /// A member of an object's `extensions`.
    pub fn extension(&self, name: &str) -> Option<Self> {
        self.get("extensions")?.get(name)
    }

    /// The members of an object.
    pub fn members(&self) -> Result<Vec<(&'a str, Self)>, ImportError> {
        let object = self.value.as_object().ok_or_else(|| self.malformed("an object is expected here"))?;
        Ok(object.iter().map(|(k, v)| (k.as_str(), self.child(k, v))).collect())
    }

    /// The items of a member that is an array, none where it is absent.
    pub fn items(&self, key: &str) -> Result<Vec<Self>, ImportError> {
        self.get(key).map_or(Ok(Vec::new()), |array| array.elements())
    }

    /// The items of an array.
    pub fn elements(&self) -> Result<Vec<Self>, ImportError> {
        let array = self.value.as_array().ok_or_else(|| self.malformed("an array is expected here"))?;
        Ok(array.iter().enumerate().map(|(i, v)| self.child(&i.to_string(), v)).collect())
    }

    pub fn string(&self) -> Result<&'a str, ImportError> {
        self.value.as_str().ok_or_else(|| self.malformed("a string is expected here"))
    }

    /// A string member, or empty.
    pub fn name(&self) -> String {
        self.value.get("name").and_then(Value::as_str).unwrap_or_default().to_owned()
    }

    /// A whole number, at least 0. Some exporters write it as 3.0.
    pub fn unsigned(&self) -> Result<u64, ImportError> {
        // Above 2⁵³ a float is not known to be the number meant.
        const EXACT: f64 = 9_007_199_254_740_992.0;
        let whole = |x: &f64| x.fract() == 0.0 && (0.0..=EXACT).contains(x);
        self.value
            .as_u64()
            .or_else(|| self.value.as_f64().filter(whole).map(|x| x as u64))
            .ok_or_else(|| self.malformed("a whole number, at least 0, is expected here"))
    }

    pub fn unsigned_or(&self, key: &str, default: u64) -> Result<u64, ImportError> {
        self.get(key).map_or(Ok(default), |value| value.unsigned())
    }

    pub fn bool_or(&self, key: &str, default: bool) -> Result<bool, ImportError> {
        self.get(key).map_or(Ok(default), |value| {
            value.value.as_bool().ok_or_else(|| value.malformed("true or false is expected here"))
        })
    }

    pub fn float(&self) -> Result<f32, ImportError> {
        let value = self.value.as_f64().map(|x| x as f32);
        value.filter(|x| x.is_finite()).ok_or_else(|| self.malformed("a finite number is expected here"))
    }

    pub fn float_or(&self, key: &str, default: f32) -> Result<f32, ImportError> {
        self.get(key).map_or(Ok(default), |value| value.float())
    }

    /// An array of so many numbers, or the default where it is absent.
    pub fn floats_or<const N: usize>(&self, key: &str, default: [f32; N]) -> Result<[f32; N], ImportError> {
        let Some(array) = self.get(key) else {
            return Ok(default);
        };
        let elements = array.elements()?;
        if elements.len() != N {
            return Err(array.malformed(format!("{N} numbers are expected here")));
        }
        let mut floats = default;
        for (float, element) in floats.iter_mut().zip(elements) {
            *float = element.float()?;
        }
        Ok(floats)
    }

    /// This as an index of something of which there are `len`.
    pub fn index(&self, what: &'static str, len: usize) -> Result<usize, ImportError> {
        let index = self.unsigned()?;
        if index < len as u64 {
            return Ok(index as usize);
        }
        Err(ImportError::OutOfRange {
            place: self.place(),
            what,
            index: index.min(i64::MAX as u64) as i64,
            len: len as u64,
        })
    }
}
