//! Numbers as they are typed, within their bounds.

use clap::builder::TypedValueParser;

/// From −∞ to ∞; what a distance may be is for the engine to say.
pub(super) fn metres(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|m: &f64| !m.is_nan());
    number.ok_or_else(|| "expected a number of metres or inf".into())
}

/// Degrees of a view that shows something.
pub(super) fn angle(text: &str) -> Result<f64, String> {
    let number = text.parse().ok();
    number
        .filter(|degrees| (0.001..=179.999).contains(degrees))
        .ok_or_else(|| "expected an angle from 0.001 to 179.999 degrees".into())
}

/// Up to a day: clocks have ends.
pub(super) fn milliseconds() -> impl TypedValueParser<Value = u64> {
    clap::value_parser!(u64).range(1..=86_400_000)
}

/// Of things that a service can hold at once.
pub(super) fn number(text: &str) -> Result<usize, String> {
    whole(text, 1_000_000)
}

/// Of a message.
pub(super) fn bytes(text: &str) -> Result<usize, String> {
    whole(text, 1 << 30)
}

/// An authority and the number of one of its systems.
pub(super) fn system(text: &str) -> Result<String, String> {
    let is_word = |word: &str| !word.is_empty() && word.chars().all(char::is_alphanumeric);
    match text.split_once(':') {
        Some((authority, code)) if is_word(authority) && is_word(code) => {
            Ok(format!("{}:{code}", authority.to_uppercase()))
        }
        _ => Err("expected an authority and a code, such as EPSG:25832".into()),
    }
}

fn whole(text: &str, most: usize) -> Result<usize, String> {
    let number = text.parse().ok();
    number
        .filter(|number| (1..=most).contains(number))
        .ok_or_else(|| format!("expected a whole number from 1 to {most}"))
}
