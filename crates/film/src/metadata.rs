//! What a file says about how its image came to be.

/// A value of one [`Metadata`] entry.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Text, UTF-8.
    Text(String),
    /// An integer. EXR has 32-bit ones only: larger ones are stored as a double where that is
    /// exact, else as digits; [`Metadata::int`] reads all three.
    Int(i64),
    /// A real number.
    Float(f64),
    /// A 4x4 matrix, rows first, applied to column vectors.
    Matrix([[f32; 4]; 4]),
}

impl Value {
    /// The value for people.
    #[must_use]
    pub fn to_text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Int(int) => int.to_string(),
            Self::Float(float) => float.to_string(),
            Self::Matrix(rows) => {
                let numbers: Vec<String> = rows.iter().flatten().map(f32::to_string).collect();
                numbers.join(" ")
            }
        }
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Value {
    fn from(float: f64) -> Self {
        Self::Float(float)
    }
}

impl From<i64> for Value {
    fn from(int: i64) -> Self {
        Self::Int(int)
    }
}

impl From<u32> for Value {
    fn from(int: u32) -> Self {
        Self::Int(int.into())
    }
}

impl From<[[f32; 4]; 4]> for Value {
    fn from(matrix: [[f32; 4]; 4]) -> Self {
        Self::Matrix(matrix)
    }
}

/// Named values. Names are plain words (`samples`); files store them as `midway:samples`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// In order of insertion; in order of name when read from a file.
    pub entries: Vec<(String, Value)>,
}

impl Metadata {
    /// No entries.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets `name`, replacing an earlier value of it.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) {
        let value = value.into();
        match self.entries.iter_mut().find(|(known, _)| known == name) {
            Some(entry) => entry.1 = value,
            None => self.entries.push((name.to_owned(), value)),
        }
    }

    /// The value of `name`.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.entries.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }

    /// `name` as text, if it is text.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.get(name)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// `name` as an integer, in whichever of the stored forms of [`Value::Int`] it is.
    #[must_use]
    pub fn int(&self, name: &str) -> Option<i64> {
        match self.get(name)? {
            Value::Int(int) => Some(*int),
            Value::Float(float) if float.fract() == 0.0 && float.abs() <= EXACT_IN_F64 as f64 => {
                Some(*float as i64)
            }
            Value::Text(digits) => digits.parse().ok(),
            _ => None,
        }
    }

    /// `name` as a real number.
    #[must_use]
    pub fn float(&self, name: &str) -> Option<f64> {
        match self.get(name)? {
            Value::Int(int) => Some(*int as f64),
            Value::Float(float) => Some(*float),
            _ => None,
        }
    }
}

/// Integers up to this magnitude survive a round trip through f64.
pub(crate) const EXACT_IN_F64: i64 = 1 << 53;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_replaces_and_numbers_convert() {
        let mut metadata = Metadata::new();
        metadata.set("seed", 1_u32);
        metadata.set("seed", 4.0e9);
        metadata.set("long", "9007199254740993");
        assert_eq!(metadata.entries.len(), 2);
        assert_eq!(metadata.int("seed"), Some(4_000_000_000));
        assert_eq!(metadata.int("long"), Some(9_007_199_254_740_993));
        assert_eq!(metadata.float("absent"), None);
    }
}
