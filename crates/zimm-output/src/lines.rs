//! Numbered lines of text of any origin.

use crate::OutputError;
use std::io::{BufRead, Read};
use std::str::FromStr;

/// No line of a trajectory is longer; what has no line ends is no text and shall not fill the memory.
const LONGEST: u64 = 1 << 20;

#[derive(Debug)]
pub(crate) struct Lines<R> {
    source: R,
    number: u64,
    line: Vec<u8>,
}

impl<R: BufRead> Lines<R> {
    pub(crate) fn new(source: R) -> Self {
        Self {
            source,
            number: 0,
            line: Vec::new(),
        }
    }

    /// The number of the last line, from 1.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// The next line, or nothing at the end of the file.
    pub(crate) fn next(&mut self) -> Result<Option<Line<'_>>, OutputError> {
        self.line.clear();
        let mut part = self.source.by_ref().take(LONGEST);
        if part.read_until(b'\n', &mut self.line)? == 0 {
            return Ok(None);
        }
        self.number += 1;
        let number = self.number;
        let wrong = |allowed| OutputError::Value {
            line: number,
            name: "the line",
            found: beginning(&String::from_utf8_lossy(&self.line)),
            allowed,
        };
        if self.line.len() as u64 == LONGEST {
            return Err(wrong("shorter than 2^20 bytes"));
        }
        let text = str::from_utf8(&self.line).map_err(|_| wrong("text in UTF-8"))?;
        Ok(Some(Line { number, text }))
    }
}

/// A line and its number, from 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<'a> {
    pub(crate) number: u64,
    pub(crate) text: &'a str,
}

impl Line<'_> {
    /// An integer.
    pub(crate) fn integer<I: FromStr>(
        &self,
        name: &'static str,
        word: &str,
        allowed: &'static str,
    ) -> Result<I, OutputError> {
        word.trim()
            .parse()
            .map_err(|_| self.wrong(name, word, allowed))
    }

    /// A finite number.
    pub(crate) fn real(&self, name: &'static str, word: &str) -> Result<f64, OutputError> {
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.wrong(name, word, "a finite number")),
        }
    }

    pub(crate) fn wrong(
        &self,
        name: &'static str,
        found: &str,
        allowed: &'static str,
    ) -> OutputError {
        OutputError::Value {
            line: self.number,
            name,
            found: beginning(found),
            allowed,
        }
    }
}

/// As much of a text as an error message bears.
pub(crate) fn beginning(text: &str) -> String {
    text.trim().chars().take(40).collect()
}
