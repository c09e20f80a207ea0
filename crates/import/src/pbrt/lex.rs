//! A pbrt file as tokens.

use std::{borrow::Cow, path::Path};

use crate::{ImportError, Place};

/// A word, a string without its quotes, or a bracket.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token<'a> {
    Word(&'a str),
    Quoted(Cow<'a, str>),
    Open,
    Close,
}

/// Reads tokens one after the other; `#` starts a comment that goes to the end of the line.
pub(super) struct Lexer<'a> {
    file: &'a Path,
    text: &'a str,
    /// Byte at which the next token is looked for.
    at: usize,
    /// Of the last token read, from 1.
    line: usize,
    peeked: Option<Token<'a>>,
}

impl<'a> Lexer<'a> {
    pub fn new(file: &'a Path, text: &'a str) -> Self {
        Self { file, text, at: 0, line: 1, peeked: None }
    }

    pub fn place(&self) -> Place {
        Place::new(self.file, self.line.to_string())
    }

    pub fn malformed(&self, problem: impl Into<String>) -> ImportError {
        ImportError::Malformed { place: self.place(), problem: problem.into() }
    }

    /// The next token; none at the end.
    pub fn next(&mut self) -> Result<Option<Token<'a>>, ImportError> {
        if let Some(token) = self.peeked.take() {
            return Ok(Some(token));
        }
        self.skip_blank();
        let rest = &self.text[self.at..];
        let Some(&first) = rest.as_bytes().first() else {
            return Ok(None);
        };
        match first {
            b'"' => self.quoted().map(Some),
            b'[' | b']' => {
                self.at += 1;
                Ok(Some(if first == b'[' { Token::Open } else { Token::Close }))
            }
            _ => {
                let ends = |b: u8| b.is_ascii_whitespace() || matches!(b, b'"' | b'[' | b']' | b'#');
                let length = rest.bytes().position(ends).unwrap_or(rest.len());
                self.at += length;
                Ok(Some(Token::Word(&rest[..length])))
            }
        }
    }

    /// The next token, left where it is.
    pub fn peek(&mut self) -> Result<Option<&Token<'a>>, ImportError> {
        if self.peeked.is_none() {
            self.peeked = self.next()?;
        }
        Ok(self.peeked.as_ref())
    }

    /// A token that has to be there.
    pub fn required(&mut self, what: &str) -> Result<Token<'a>, ImportError> {
        self.next()?.ok_or_else(|| self.malformed(format!("the file ends where {what} is expected")))
    }

    /// A string that has to be there.
    pub fn string(&mut self) -> Result<Cow<'a, str>, ImportError> {
        match self.required("a string")? {
            Token::Quoted(text) => Ok(text),
            other => Err(self.malformed(format!("a string is expected instead of {}", shown(&other)))),
        }
    }

    /// A finite number that has to be there.
    pub fn number(&mut self) -> Result<f64, ImportError> {
        match self.required("a number")? {
            Token::Word(word) => self.parse_number(word),
            other => Err(self.malformed(format!("a number is expected instead of {}", shown(&other)))),
        }
    }

    pub fn parse_number(&self, word: &str) -> Result<f64, ImportError> {
        let problem = |what: &str| self.malformed(format!("{} is not {what}", shown(&Token::Word(word))));
        let number: f64 = word.parse().map_err(|_| problem("a number"))?;
        if number.is_finite() { Ok(number) } else { Err(problem("a finite number")) }
    }

    /// So many numbers, in brackets or not.
    pub fn numbers<const N: usize>(&mut self) -> Result<[f64; N], ImportError> {
        let bracketed = self.peek()? == Some(&Token::Open);
        if bracketed {
            self.next()?;
        }
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        if bracketed && self.next()? != Some(Token::Close) {
            return Err(self.malformed(format!("{N} numbers and a closing bracket are expected")));
        }
        Ok(numbers)
    }

    fn skip_blank(&mut self) {
        let bytes = self.text.as_bytes();
        let mut comment = false;
        while let Some(&byte) = bytes.get(self.at) {
            match byte {
                b'\n' => {
                    self.line += 1;
                    comment = false;
                }
                b'#' => comment = true,
                _ if comment || byte.is_ascii_whitespace() => {}
                _ => return,
            }
            self.at += 1;
        }
    }

    fn quoted(&mut self) -> Result<Token<'a>, ImportError> {
        let body = &self.text[self.at + 1..];
        let mut escaped = false;
        let mut any_escape = false;
        for (i, byte) in body.bytes().enumerate() {
            match byte {
                b'\n' => break,
                _ if escaped => escaped = false,
                b'\\' => {
                    escaped = true;
                    any_escape = true;
                }
                b'"' => {
                    self.at += i + 2;
                    let text = &body[..i];
                    let text = if any_escape { Cow::Owned(unescaped(text)) } else { Cow::Borrowed(text) };
                    return Ok(Token::Quoted(text));
                }
                _ => {}
            }
        }
        Err(self.malformed("a string has no closing quote on its line"))
    }
}

fn unescaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut characters = text.chars();
    while let Some(c) = characters.next() {
        match (c, if c == '\\' { characters.next() } else { None }) {
            ('\\', Some('n')) => out.push('\n'),
            ('\\', Some('t')) => out.push('\t'),
            ('\\', Some(other)) => out.push(other),
            (c, _) => out.push(c),
        }
    }
    out
}

/// A token for a message of one line.
pub(super) fn shown(token: &Token) -> String {
    match token {
        Token::Word(word) => shortened(word),
        Token::Quoted(text) => format!("\"{}\"", shortened(text)),
        Token::Open => "[".to_owned(),
        Token::Close => "]".to_owned(),
    }
}

/// Enough of a name to recognise it, and without control characters.
pub(super) fn shortened(name: &str) -> String {
    name.chars().take(60).map(|c| if c.is_control() { '?' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Result<Vec<Token<'_>>, ImportError> {
        let mut lexer = Lexer::new(Path::new("a.pbrt"), text);
        let mut tokens = Vec::new();
        while let Some(token) = lexer.next()? {
            tokens.push(token);
        }
        Ok(tokens)
    }

    #[test]
    fn tokens_need_no_blanks_between_them() {
        let found = tokens("Shape\"a b\"[1 -2.5]# [ \" \nEnd").unwrap();
        let quoted = |s: &'static str| Token::Quoted(s.into());
        let word = Token::Word;
        assert_eq!(
            found,
            [word("Shape"), quoted("a b"), Token::Open, word("1"), word("-2.5"), Token::Close, word("End")]
        );
        assert_eq!(tokens(r#" "a\"b\\\n" "#).unwrap(), [Token::Quoted("a\"b\\\n".into())]);
        assert_eq!(tokens("\u{fc}ber").unwrap(), [word("\u{fc}ber")]);
        assert!(tokens("").unwrap().is_empty());
    }

    #[test]
    fn strings_have_to_end() {
        for text in ["\"", "a\n\"bc\nd\"", "\"a\\\""] {
            let line = tokens(text).unwrap_err().to_string();
            assert!(line.contains("closing quote") && line.contains("a.pbrt:"), "{line}");
        }
    }

    #[test]
    fn numbers_with_and_without_brackets() {
        let read = |text: &str| Lexer::new(Path::new("a.pbrt"), text).numbers::<2>();
        assert_eq!(read("[1 2e1]").unwrap(), [1.0, 20.0]);
        assert_eq!(read("1 .5 3").unwrap(), [1.0, 0.5]);
        for bad in ["[1]", "[1 2 3]", "1", "1 x", "nan 1", "1 inf", "1 1e999", "\"1\" 2"] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
