use std::io::Read;
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::import::source::Source;
use crate::import::{ImportError, Place};

/// Bytes taken from the source at a time.
const CHUNK_BYTES: usize = 256 * 1024;

/// What comes next between brackets.
#[derive(Debug, Clone, Copy)]
pub(in crate::import) enum Next {
    /// Where the item begins.
    Item(usize),
    /// The position behind the closing bracket.
    End(usize),
}

/// Splits JSON values off a stream; only the value at hand is in memory.
///
/// Positions are bytes from the first one that is not consumed; reading on does not move them.
pub(in crate::import) struct Splitter<'a> {
    source: &'a Source,
    reader: Box<dyn Read + 'a>,
    buffer: Vec<u8>,
    consumed: usize,
    ended: bool,
    limit: usize,
    /// Line and column of position 0, from 1; the column counts bytes.
    line: usize,
    column: usize,
}

impl<'a> Splitter<'a> {
    /// A value of more than `limit` bytes is refused.
    pub(in crate::import) fn new(
        source: &'a Source,
        report: &'a dyn Fn(u64),
        limit: usize,
    ) -> Result<Self, ImportError> {
        let mut splitter = Self {
            source,
            reader: source.reader(report)?,
            buffer: Vec::new(),
            consumed: 0,
            ended: false,
            limit,
            line: 1,
            column: 1,
        };
        splitter.byte(0)?;
        if splitter.buffer.starts_with("\u{feff}".as_bytes()) {
            splitter.consume(3);
        }
        Ok(splitter)
    }

    /// The file.
    pub(in crate::import) fn path(&self) -> &Path {
        self.source.path()
    }

    /// The bytes at hand from `from` to `to`.
    pub(in crate::import) fn bytes(&self, from: usize, to: usize) -> &[u8] {
        &self.buffer[self.consumed + from..self.consumed + to]
    }

    /// Goes on to `position`, which becomes 0.
    pub(in crate::import) fn consume(&mut self, position: usize) {
        (self.line, self.column) = self.line_and_column(position);
        self.consumed += position;
    }

    /// The byte there; `None` at the end of the file.
    pub(in crate::import) fn byte(&mut self, position: usize) -> Result<Option<u8>, ImportError> {
        loop {
            if let Some(&byte) = self.buffer.get(self.consumed + position) {
                return Ok(Some(byte));
            }
            if self.ended {
                return Ok(None);
            }
            self.fill()?;
        }
    }

    /// The next position that is neither white space nor a record separator (RFC 8142).
    pub(in crate::import) fn skip_space(&mut self, from: usize) -> Result<usize, ImportError> {
        let mut position = from;
        while let Some(b' ' | b'\n' | b'\r' | b'\t' | 0x1e) = self.byte(position)? {
            position += 1;
            if position - from >= CHUNK_BYTES && from == 0 {
                self.consume(position);
                position = 0;
            }
        }
        Ok(position)
    }

    /// What comes behind an opening bracket: the first item, or the end.
    pub(in crate::import) fn first(&mut self, from: usize, close: u8) -> Result<Next, ImportError> {
        let at = self.skip_space(from)?;
        match self.byte(at)? {
            Some(byte) if byte == close => Ok(Next::End(at + 1)),
            Some(_) => Ok(Next::Item(at)),
            None => Err(self.end_of_file()),
        }
    }

    /// What comes behind an item: another one, or the end.
    pub(in crate::import) fn next(&mut self, from: usize, close: u8) -> Result<Next, ImportError> {
        let at = self.skip_space(from)?;
        match self.byte(at)? {
            Some(b',') => match self.first(at + 1, close)? {
                Next::Item(item) => Ok(Next::Item(item)),
                Next::End(_) => Err(self.malformed(at, "trailing comma")),
            },
            Some(byte) if byte == close => Ok(Next::End(at + 1)),
            Some(_) => Err(self.malformed(at, format!("expected `,` or `{}`", char::from(close)))),
            None => Err(self.end_of_file()),
        }
    }

    /// The key at `from` and where its value begins.
    pub(in crate::import) fn member(
        &mut self,
        from: usize,
    ) -> Result<(String, usize), ImportError> {
        if self.byte(from)? != Some(b'"') {
            return Err(self.malformed(from, "expected a member name in quotes"));
        }
        let end = self.value_end(from)?;
        let key = serde_json::from_str(self.text(from, end)?).map_err(|e| self.syntax(from, &e))?;
        let colon = self.skip_space(end)?;
        match self.byte(colon)? {
            Some(b':') => {}
            Some(_) => return Err(self.malformed(colon, "expected `:`")),
            None => return Err(self.end_of_file()),
        }
        let value = self.skip_space(colon + 1)?;
        if self.byte(value)?.is_none() {
            return Err(self.end_of_file());
        }
        Ok((key, value))
    }

    /// The position behind the value that begins at `from`.
    ///
    /// Only quotes and the value's own kind of bracket are looked at, which finds the end of any
    /// valid value; whether it is valid shows when it is parsed.
    pub(in crate::import) fn value_end(&mut self, from: usize) -> Result<usize, ImportError> {
        match self.byte(from)? {
            Some(b'"') => self.string_end(from),
            Some(b'{') => self.bracket_end(from, b'{', b'}'),
            Some(b'[') => self.bracket_end(from, b'[', b']'),
            _ => self.scalar_end(from),
        }
    }

    fn bracket_end(&mut self, from: usize, open: u8, close: u8) -> Result<usize, ImportError> {
        let mut depth = 1_usize;
        let mut position = from + 1;
        loop {
            let rest = &self.buffer[self.consumed + position..];
            match memchr::memchr3(b'"', open, close, rest) {
                None => {
                    position += rest.len();
                    self.more(from)?;
                }
                Some(found) => {
                    position += found + 1;
                    let byte = rest[found];
                    if byte == b'"' {
                        position = self.string_end_of(from, position)?;
                    } else if byte == open {
                        depth += 1;
                    } else {
                        depth -= 1;
                        if depth == 0 {
                            return Ok(position);
                        }
                    }
                }
            }
        }
    }

    fn string_end(&mut self, from: usize) -> Result<usize, ImportError> {
        self.string_end_of(from, from + 1)
    }

    /// The position behind the closing quote; `value` is where the whole value begins.
    fn string_end_of(&mut self, value: usize, inside: usize) -> Result<usize, ImportError> {
        let mut position = inside;
        loop {
            let rest = self
                .buffer
                .get(self.consumed + position..)
                .unwrap_or_default();
            match memchr::memchr2(b'"', b'\\', rest) {
                None => {
                    position += rest.len();
                    self.more(value)?;
                }
                Some(found) if rest[found] == b'"' => return Ok(position + found + 1),
                Some(found) => {
                    position += found + 2;
                    while self.buffer.len() < self.consumed + position {
                        self.more(value)?;
                    }
                }
            }
        }
    }

    fn scalar_end(&mut self, from: usize) -> Result<usize, ImportError> {
        let mut position = from;
        while let Some(byte) = self.byte(position)? {
            if matches!(
                byte,
                b',' | b']' | b'}' | b' ' | b'\n' | b'\r' | b'\t' | 0x1e
            ) {
                break;
            }
            position += 1;
        }
        Ok(position)
    }

    /// Reads on within the value that begins at `from`.
    fn more(&mut self, from: usize) -> Result<(), ImportError> {
        if self.buffer.len() - self.consumed - from > self.limit {
            return Err(self.malformed(
                from,
                format!("a value of more than {} bytes; split it", self.limit),
            ));
        }
        if self.ended {
            return Err(self.incomplete(from));
        }
        self.fill()
    }

    fn fill(&mut self) -> Result<(), ImportError> {
        self.buffer.drain(..self.consumed);
        self.consumed = 0;
        let read = (&mut self.reader)
            .take(CHUNK_BYTES as u64)
            .read_to_end(&mut self.buffer)
            .map_err(|e| self.source.io_error(e))?;
        self.ended = read == 0;
        Ok(())
    }

    /// Why the value at `from` has no end: what is wrong in it, or that the file is cut off.
    fn incomplete(&self, from: usize) -> ImportError {
        let rest = &self.buffer[self.consumed + from..];
        let mut parser = serde_json::Deserializer::from_slice(rest);
        match IgnoredAny::deserialize(&mut parser) {
            Err(e) if !e.is_eof() => self.syntax(from, &e),
            _ => self.end_of_file(),
        }
    }

    /// The file ends where it must not.
    pub(in crate::import) fn end_of_file(&self) -> ImportError {
        self.malformed(
            self.buffer.len() - self.consumed,
            "the file ends inside a JSON value; it may be cut off",
        )
    }

    /// The error `serde_json` found in the value at `from`, at its place in the file.
    pub(in crate::import) fn syntax(&self, from: usize, error: &serde_json::Error) -> ImportError {
        ImportError::malformed(
            self.source.path(),
            self.place_of(from, error),
            super::reason(error),
        )
    }

    /// Where in the file `serde_json` found an error in the value at `from`.
    pub(in crate::import) fn place_of(&self, from: usize, error: &serde_json::Error) -> Place {
        let (line, column) = self.line_and_column(from);
        match error.line() {
            0 => Place::Line(line, column),
            1 => Place::Line(line, (column + error.column()).saturating_sub(1).max(1)),
            n => Place::Line(line + n - 1, error.column().max(1)),
        }
    }

    /// An error at `position`.
    pub(in crate::import) fn malformed(
        &self,
        position: usize,
        reason: impl Into<String>,
    ) -> ImportError {
        ImportError::malformed(self.source.path(), self.place(position), reason)
    }

    pub(in crate::import) fn place(&self, position: usize) -> Place {
        let (line, column) = self.line_and_column(position);
        Place::Line(line, column)
    }

    /// The text at hand from `from` to `to`.
    ///
    /// # Errors
    /// [`ImportError::Malformed`] where it is not UTF-8.
    pub(in crate::import) fn text(&self, from: usize, to: usize) -> Result<&str, ImportError> {
        std::str::from_utf8(self.bytes(from, to))
            .map_err(|e| self.malformed(from + e.valid_up_to(), "not UTF-8, as JSON must be"))
    }

    fn line_and_column(&self, position: usize) -> (usize, usize) {
        let before = self.bytes(0, position);
        match memchr::memrchr(b'\n', before) {
            None => (self.line, self.column + position),
            Some(last) => (
                self.line + memchr::memchr_iter(b'\n', before).count(),
                position - last,
            ),
        }
    }
}
