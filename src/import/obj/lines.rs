//! The statements of an OBJ file and the words in them, without copying.

use super::super::Place;

/// One statement: a line, with the lines that a trailing `\` joins to it.
pub(super) struct Line<'a> {
    /// Without the end of the line.
    bytes: &'a [u8],
    /// Of its first line, from 1.
    number: usize,
    keyword: (usize, usize),
}

/// The statements of `text`, comments and empty lines included.
pub(super) fn lines(text: &[u8]) -> impl Iterator<Item = Line<'_>> {
    const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
    let mut rest = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
    let mut next_number = 1;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let number = next_number;
        let mut end = 0;
        loop {
            next_number += 1;
            end += memchr::memchr(b'\n', &rest[end..]).unwrap_or(rest.len() - end);
            if end == rest.len() || !continues(&rest[..end]) {
                break;
            }
            end += 1;
        }
        let line = Line::new(&rest[..end], number);
        rest = rest.get(end + 1..).unwrap_or_default();
        Some(line)
    })
}

/// Whether a line ends in `\`, with or without a carriage return.
fn continues(line: &[u8]) -> bool {
    line.strip_suffix(b"\r").unwrap_or(line).ends_with(b"\\")
}

impl<'a> Line<'a> {
    fn new(bytes: &'a [u8], number: usize) -> Self {
        let start = bytes.iter().position(|b| !is_space(*b));
        let start = start.unwrap_or(bytes.len());
        let length = match bytes.get(start) {
            // A comment needs no blank after its sign.
            Some(b'#') | None => 0,
            _ => word_length(&bytes[start..]),
        };
        Self {
            bytes,
            number,
            keyword: (start, start + length),
        }
    }

    /// First word; empty for a comment or a blank line.
    pub(super) fn keyword(&self) -> &'a [u8] {
        &self.bytes[self.keyword.0..self.keyword.1]
    }

    /// The words after the keyword, up to a comment.
    pub(super) fn words(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let mut rest = &self.bytes[self.keyword.1..];
        std::iter::from_fn(move || {
            let start = rest.iter().position(|b| !is_space(*b))?;
            if rest[start] == b'#' {
                return None;
            }
            let (word, after) = rest[start..].split_at(word_length(&rest[start..]));
            rest = after;
            Some(word)
        })
    }

    /// Everything after the keyword, without the blanks around it: a name may hold blanks.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes[self.keyword.1..].trim_ascii()
    }

    /// Where the statement begins.
    pub(super) fn start(&self) -> Place {
        self.at(self.keyword.0)
    }

    /// Where one more word would have begun.
    pub(super) fn end(&self) -> Place {
        self.at(self.bytes.trim_ascii_end().len())
    }

    /// Where `word`, one of [`Self::words`], begins.
    pub(super) fn place(&self, word: &[u8]) -> Place {
        self.at(word.as_ptr() as usize - self.bytes.as_ptr() as usize)
    }

    fn at(&self, offset: usize) -> Place {
        let before = &self.bytes[..offset];
        let line_start = memchr::memrchr(b'\n', before).map_or(0, |newline| newline + 1);
        let joined = memchr::memchr_iter(b'\n', before).count();
        Place::Line(self.number + joined, offset - line_start + 1)
    }
}

/// A `\` counts as a blank: it stands only where a line is continued.
fn is_space(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == b'\\' || byte == 0x0b
}

fn word_length(bytes: &[u8]) -> usize {
    let end = bytes.iter().position(|b| is_space(*b));
    end.unwrap_or(bytes.len())
}
