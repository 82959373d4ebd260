/// One step through nested arrays of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::import) enum Token {
    Open,
    Close,
    /// Infinite where the text says more than an f64 can hold.
    Number(f64),
    /// A string, an object, `true`, `false` or `null`: nothing a coordinate can be.
    Other,
}

/// Walks the text of nested arrays of any depth without recursion.
///
/// The text must be valid JSON, as that of a `RawValue` is; of other text the tokens mean
/// nothing, but nothing worse happens. After [`Token::Other`] the walk is over.
pub(in crate::import) struct Arrays<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Arrays<'a> {
    pub(in crate::import) fn new(text: &'a str) -> Self {
        Self { text, at: 0 }
    }
}

impl Iterator for Arrays<'_> {
    type Item = Token;

    #[inline]
    fn next(&mut self) -> Option<Token> {
        let bytes = self.text.as_bytes();
        loop {
            let byte = *bytes.get(self.at)?;
            match byte {
                b',' | b' ' | b'\n' | b'\r' | b'\t' => self.at += 1,
                b'[' => {
                    self.at += 1;
                    return Some(Token::Open);
                }
                b']' => {
                    self.at += 1;
                    return Some(Token::Close);
                }
                b'-' | b'0'..=b'9' => {
                    let (number, length) = number(&self.text[self.at..]);
                    self.at += length;
                    return Some(Token::Number(number));
                }
                _ => {
                    self.at = bytes.len();
                    return Some(Token::Other);
                }
            }
        }
    }
}

/// Powers of ten that an f64 holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// The number that the text begins with, rounded to the nearest f64, and its length in bytes.
///
/// Up to 2^53 and 22 decimals both parts are exact, so that one division rounds correctly
/// (Clinger, "How to read floating point numbers accurately", 1990). All else is left to `std`.
#[inline]
fn number(text: &str) -> (f64, usize) {
    let bytes = text.as_bytes();
    let negative = bytes.first() == Some(&b'-');
    let mut at = usize::from(negative);
    let mut digits: u64 = 0;
    let first = at;
    while let Some(digit) = digit(bytes, at) {
        digits = digits.wrapping_mul(10).wrapping_add(digit);
        at += 1;
    }
    let mut count = at - first;
    let mut decimals = 0;
    if bytes.get(at) == Some(&b'.') {
        let point = at;
        at += 1;
        while let Some(digit) = digit(bytes, at) {
            digits = digits.wrapping_mul(10).wrapping_add(digit);
            at += 1;
        }
        decimals = at - point - 1;
        count += decimals;
    }
    let exponent = matches!(bytes.get(at), Some(b'e' | b'E'));
    if exponent || count > 19 || digits > 1 << 53 || decimals >= POWERS.len() {
        return by_std(text);
    }
    let value = digits as f64 / POWERS[decimals];
    (if negative { -value } else { value }, at)
}

#[inline]
fn digit(bytes: &[u8], at: usize) -> Option<u64> {
    let digit = bytes.get(at)?.wrapping_sub(b'0');
    (digit < 10).then_some(u64::from(digit))
}

#[cold]
fn by_std(text: &str) -> (f64, usize) {
    let length = text
        .bytes()
        .position(|b| !matches!(b, b'0'..=b'9' | b'-' | b'+' | b'.' | b'e' | b'E'))
        .unwrap_or(text.len());
    (text[..length].parse().unwrap_or(f64::NAN), length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_std() {
        let mut state = 1_u64;
        for round in 0..200_000_u64 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(round | 1);
            let text = match round % 4 {
                0 => format!("{}", f64::from_bits(state)),
                1 => format!("{:e}", f64::from_bits(state)),
                2 => format!("{}.{}", state >> 50, state % 1_000_000_000),
                _ => format!("-{}", state >> (round % 64)),
            };
            let Ok(expected) = text.parse::<f64>() else {
                continue;
            };
            if !expected.is_finite() {
                continue;
            }
            let (value, length) = number(&text);
            assert_eq!(value.to_bits(), expected.to_bits(), "{text}");
            assert_eq!(length, text.len());
        }
    }

    #[test]
    fn tokens_of_nested_arrays() {
        use Token::{Close, Number, Open, Other};
        let tokens: Vec<_> = Arrays::new("[[1, -2.5e1],\n[], 1e999]").collect();
        assert_eq!(
            tokens,
            [
                Open,
                Open,
                Number(1.0),
                Number(-25.0),
                Close,
                Open,
                Close,
                Number(f64::INFINITY),
                Close
            ]
        );
        assert_eq!(
            Arrays::new("[null,1]").collect::<Vec<_>>(),
            [Open, Other],
            "nothing can be said after what is no number"
        );
    }
}
