//! A directive's parameters: `"type name" values`, in the syntax of both versions.

use std::{cell::Cell, rc::Rc};

use glam::{Vec2, Vec3};

use super::lex::{Lexer, Token, shortened, shown};
use crate::{
    ImportError, Place,
    warning::{WarningKind, Warnings},
};

/// What a parameter holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Strings(Vec<String>),
    Bools(Vec<bool>),
}

/// A parameter.
#[derive(Clone, Debug)]
pub(super) struct Param {
    /// `float`, `rgb`, `texture`, …
    pub kind: String,
    pub name: String,
    pub values: Values,
    used: Cell<bool>,
}

/// The parameters of one directive.
#[derive(Clone, Debug)]
pub(super) struct Params {
    list: Vec<Param>,
    /// Those of `Attribute` directives, which count where the directive has none of that name.
    defaults: Rc<[Param]>,
    pub place: Place,
}

impl Params {
    /// Reads as many as there are.
    pub fn read(lexer: &mut Lexer) -> Result<Self, ImportError> {
        let place = lexer.place();
        let mut list = Vec::new();
        while let Some(Token::Quoted(declaration)) = lexer.peek()? {
            let declaration = declaration.to_string();
            lexer.next()?;
            let mut words = declaration.split_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                let problem = format!("\"{}\" is not a type and a name", shortened(&declaration));
                return Err(lexer.malformed(problem));
            };
            let values = read_values(lexer)?;
            let (kind, name) = (kind.to_owned(), name.to_owned());
            list.push(Param { kind, name, values, used: Cell::new(false) });
        }
        Ok(Self { list, defaults: Rc::new([]), place })
    }

    /// None.
    pub fn empty(place: Place) -> Self {
        Self { list: Vec::new(), defaults: Rc::new([]), place }
    }

    /// Has these stand in where a parameter is missing.
    pub fn with_defaults(mut self, defaults: Option<&Rc<[Param]>>) -> Self {
        if let Some(defaults) = defaults {
            self.defaults = defaults.clone();
        }
        self
    }

    pub fn into_list(self) -> Vec<Param> {
        self.list
    }

    /// Marks it as used.
    pub fn get(&self, name: &str) -> Option<&Param> {
        let found = self.list.iter().chain(self.defaults.iter()).find(|p| p.name == name)?;
        found.used.set(true);
        Some(found)
    }

    pub fn has(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    pub fn malformed(&self, problem: impl Into<String>) -> ImportError {
        ImportError::Malformed { place: self.place.clone(), problem: problem.into() }
    }

    /// Those that say nothing about the image, or that stand for what is decided elsewhere.
    pub fn ignore(&self, names: &[&str]) {
        for name in names {
            self.get(name);
        }
    }

    /// Warns of what nothing asked for.
    pub fn warn_of_unused(&self, owner: &str, warnings: &mut Warnings) {
        for param in self.list.iter().filter(|p| !p.used.get()) {
            let (name, owner) = (shortened(&param.name), shortened(owner));
            let message = format!("the parameter \"{name}\" of {owner} is not used");
            warnings.add(WarningKind::Unused, self.place.short(), message);
        }
    }

    pub fn numbers(&self, name: &str) -> Result<Option<&[f64]>, ImportError> {
        match self.get(name).map(|p| &p.values) {
            None => Ok(None),
            Some(Values::Numbers(numbers)) => Ok(Some(numbers)),
            Some(_) => Err(self.malformed(format!("\"{}\" has to hold numbers", shortened(name)))),
        }
    }

    pub fn float(&self, name: &str) -> Result<Option<f32>, ImportError> {
        let Some(numbers) = self.numbers(name)? else {
            return Ok(None);
        };
        let [number] = *numbers else {
            return Err(self.malformed(format!("\"{}\" has to be one number", shortened(name))));
        };
        self.single(name, number).map(Some)
    }

    pub fn float_or(&self, name: &str, default: f32) -> Result<f32, ImportError> {
        Ok(self.float(name)?.unwrap_or(default))
    }

    pub fn string(&self, name: &str) -> Result<Option<&str>, ImportError> {
        match self.get(name).map(|p| &p.values) {
            None => Ok(None),
            Some(Values::Strings(strings)) if strings.len() == 1 => Ok(Some(&strings[0])),
            Some(_) => Err(self.malformed(format!("\"{}\" has to be one string", shortened(name)))),
        }
    }

    pub fn strings(&self, name: &str) -> Result<Option<&[String]>, ImportError> {
        match self.get(name).map(|p| &p.values) {
            None => Ok(None),
            Some(Values::Strings(strings)) => Ok(Some(strings)),
            Some(_) => Err(self.malformed(format!("\"{}\" has to hold strings", shortened(name)))),
        }
    }

    /// `true` as a word or as a string.
    pub fn bool_or(&self, name: &str, default: bool) -> Result<bool, ImportError> {
        match self.get(name).map(|p| &p.values) {
            None => Ok(default),
            Some(Values::Bools(values)) if values.len() == 1 => Ok(values[0]),
            Some(Values::Strings(values)) if values.len() == 1 && values[0] == "true" => Ok(true),
            Some(Values::Strings(values)) if values.len() == 1 && values[0] == "false" => Ok(false),
            Some(_) => Err(self.malformed(format!("\"{}\" has to be true or false", shortened(name)))),
        }
    }

    /// The name of a texture, where the parameter is one.
    pub fn texture(&self, name: &str) -> Result<Option<&str>, ImportError> {
        match self.get(name) {
            Some(param) if param.kind == "texture" => self.string(name),
            _ => Ok(None),
        }
    }

    pub fn point_or(&self, name: &str, default: Vec3) -> Result<Vec3, ImportError> {
        match &self.points(name)?[..] {
            [] => Ok(default),
            [point] => Ok(*point),
            _ => Err(self.malformed(format!("\"{}\" has to be three numbers", shortened(name)))),
        }
    }

    /// Empty where there are none.
    pub fn points(&self, name: &str) -> Result<Vec<Vec3>, ImportError> {
        self.tuples::<3>(name)?.into_iter().map(|p| Ok(Vec3::from_array(p))).collect()
    }

    /// Empty where there are none.
    pub fn points2(&self, name: &str) -> Result<Vec<Vec2>, ImportError> {
        self.tuples::<2>(name)?.into_iter().map(|p| Ok(Vec2::from_array(p))).collect()
    }

    fn tuples<const N: usize>(&self, name: &str) -> Result<Vec<[f32; N]>, ImportError> {
        let numbers = self.numbers(name)?.unwrap_or_default();
        if !numbers.len().is_multiple_of(N) {
            let problem = format!("\"{}\" has to hold {N} numbers for each point", shortened(name));
            return Err(self.malformed(problem));
        }
        let mut tuples = Vec::with_capacity(numbers.len() / N);
        for chunk in numbers.chunks_exact(N) {
            let mut tuple = [0.0; N];
            for (to, &from) in tuple.iter_mut().zip(chunk) {
                *to = self.single(name, from)?;
            }
            tuples.push(tuple);
        }
        Ok(tuples)
    }

    /// Indices of `n` things; empty where the parameter is missing.
    pub fn indices(&self, name: &str, what: &'static str, n: usize) -> Result<Vec<u32>, ImportError> {
        let check = |&x: &f64| {
            if x.fract() == 0.0 && (0.0..n as f64).contains(&x) && x < f64::from(u32::MAX) {
                return Ok(x as u32);
            }
            let (place, index) = (self.place.clone(), x as i64);
            Err(ImportError::OutOfRange { place, what, index, len: n as u64 })
        };
        self.numbers(name)?.unwrap_or_default().iter().map(check).collect()
    }

    /// As f32, where it is not beyond its range.
    pub fn single(&self, name: &str, number: f64) -> Result<f32, ImportError> {
        let single = number as f32;
        if single.is_finite() {
            return Ok(single);
        }
        Err(self.malformed(format!("a number of \"{}\" is too large", shortened(name))))
    }
}

/// Reads a value, or several in brackets, and forgets them.
pub(super) fn skip_value(lexer: &mut Lexer) -> Result<(), ImportError> {
    read_values(lexer).map(drop)
}

fn read_values(lexer: &mut Lexer) -> Result<Values, ImportError> {
    let first = lexer.required("a value")?;
    if first != Token::Open {
        return read_list(lexer, first, false);
    }
    match lexer.required("a value")? {
        Token::Close => Ok(Values::Numbers(Vec::new())),
        first => read_list(lexer, first, true),
    }
}

/// Values of the first one's kind, up to the bracket, or that one alone.
fn read_list(lexer: &mut Lexer, first: Token, bracketed: bool) -> Result<Values, ImportError> {
    let mut values = match &first {
        Token::Quoted(_) => Values::Strings(Vec::new()),
        Token::Word("true" | "false") => Values::Bools(Vec::new()),
        _ => Values::Numbers(Vec::new()),
    };
    let mut token = first;
    loop {
        match (&mut values, &token) {
            (Values::Numbers(list), Token::Word(word)) => list.push(lexer.parse_number(word)?),
            (Values::Strings(list), Token::Quoted(text)) => list.push(text.to_string()),
            (Values::Bools(list), Token::Word(word @ ("true" | "false"))) => list.push(*word == "true"),
            (_, other) => {
                return Err(lexer.malformed(format!("{} is not expected among the values", shown(other))));
            }
        }
        if !bracketed {
            return Ok(values);
        }
        token = lexer.required("a closing bracket")?;
        if token == Token::Close {
            return Ok(values);
        }
    }
}
