//! Numbers and summaries as people read them.

use crate::geom::DVec3;
use crate::index::LodTree;

/// `23,951`
pub(super) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (at, digit) in digits.char_indices() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `1 level`, `2 levels`
pub(super) fn counted(number: u64, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", grouped(number))
}

/// To the millimetre, without zeros that say nothing.
pub(super) fn metres(number: f64) -> String {
    let text = format!("{number:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.to_owned()
}

/// To a tenth of a pixel; numbers of many digits by their power of ten.
pub(super) fn pixels(number: f64) -> String {
    if number < 1e6 {
        format!("{number:.1}")
    } else {
        format!("{number:.1e}")
    }
}

/// A point or a size to the millimetre.
pub(super) fn point(point: DVec3, between: &str) -> String {
    point.to_array().map(metres).join(between)
}

/// A word of a command, quoted where a shell would take it apart.
pub(super) fn word(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+,:@%=".contains(c);
    if text.chars().all(is_plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

/// What a file holds, in one line.
pub(super) fn summary(tree: &LodTree) -> String {
    format!(
        "{}, {}, {}{}",
        counted(tree.object_count().into(), "object"),
        counted(tree.level_count().into(), "level"),
        counted(tree.byte_len() as u64, "byte"),
        tree.crs().map(|crs| format!(", {crs}")).unwrap_or_default(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words() {
        for (text, quoted) in [
            ("/a/b-1.citylod", "/a/b-1.citylod"),
            ("Køln.citylod", "Køln.citylod"),
            ("a b.citylod", "'a b.citylod'"),
            ("o'b $HOME", r"'o'\''b $HOME'"),
        ] {
            assert_eq!(word(text), quoted);
        }
    }

    #[test]
    fn numbers() {
        for (number, text) in [
            (0, "0"),
            (999, "999"),
            (23_951, "23,951"),
            (1_000_000, "1,000,000"),
        ] {
            assert_eq!(grouped(number), text);
        }
        assert_eq!(counted(1, "level"), "1 level");
        assert_eq!(counted(0, "level"), "0 levels");
        for (number, text) in [
            (1.0, "1"),
            (-0.000_1, "0"),
            (100.0, "100"),
            (0.123_4, "0.123"),
        ] {
            assert_eq!(metres(number), text);
        }
    }
}
