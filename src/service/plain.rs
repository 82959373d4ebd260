//! What a parser says of a body, in words for people who wrote the body.

use std::borrow::Cow;

/// Longest text of a body that is repeated to who sent it, characters.
const LONGEST: usize = 40;

/// What is wrong, as `serde` and `serde_json` have it, with the member by its name; `member` is
/// where it was found, empty for the body as a whole.
pub(super) fn plain(said: &str, member: &str) -> String {
    let whole = if member.is_empty() {
        "the body"
    } else {
        member
    };
    if let Some(words) = of_syntax(said) {
        return match member {
            "" => words.to_owned(),
            _ => format!("at {member}: {words}"),
        };
    }
    let of_member = |rest: &str| match rest.trim_end_matches('`') {
        name if member.is_empty() => name.to_owned(),
        name => format!("{member}.{name}"),
    };
    if let Some(name) = said.strip_prefix("missing field `") {
        return format!("{} is missing", of_member(name));
    }
    if let Some(name) = said.strip_prefix("duplicate field `") {
        return format!("{} is given twice", of_member(name));
    }
    let unknown = |what| {
        let ends = ["`, expected ", "`, there are no fields"];
        ends.into_iter().find_map(|end| parts(said, what, end))
    };
    if let Some((name, known)) = unknown("unknown field `") {
        let owner = member.rsplit_once(name).map_or(member, |(owner, _)| owner);
        let owner = match owner.trim_end_matches('.') {
            "" => "the body",
            owner => owner,
        };
        let name = shortened(name);
        return match quoted(known).join(", ") {
            none if none.is_empty() => format!("{owner} has no member {name}, as it has none"),
            names => format!("{owner} has no member {name}; it has {names}"),
        };
    }
    if let Some((word, known)) = unknown("unknown variant `") {
        let (word, words) = (shortened(word), quoted(known).join(", "));
        return format!("{whole} must be one of {words}, and is \"{word}\"");
    }
    if let Some((length, wanted)) = parts(said, "invalid length ", ", expected ") {
        return format!("{whole} must be {}, and has {length}", thing(wanted));
    }
    for kind in ["invalid type: ", "invalid value: "] {
        if let Some((found, wanted)) = parts(said, kind, ", expected ") {
            return format!("{whole} must be {}, and is {}", thing(wanted), value(found));
        }
    }
    said.to_owned()
}

/// What lies behind `before`, on either side of `between`.
fn parts<'a>(said: &'a str, before: &str, between: &str) -> Option<(&'a str, &'a str)> {
    said.strip_prefix(before)?.rsplit_once(between)
}

/// What stands between backticks.
fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

/// What is no JSON, and what there should be.
fn of_syntax(said: &str) -> Option<&'static str> {
    Some(match said {
        "trailing characters" => "more follows where the body should end; send one JSON object",
        "key must be a string" => "a name of a member must stand in double quotation marks",
        "expected value" | "expected ident" => {
            "this is no value of JSON, which are numbers, texts in double quotation marks, lists, \
             objects, true, false and null"
        }
        "invalid number" => {
            "this is no number of JSON: such as 12, -0.5 or 6e3, without zeros or a plus before it"
        }
        "number out of range" => "the number is too large; numbers may reach to 1.7e308",
        "trailing comma" => "a comma must be followed by something",
        "expected `:`" => "a colon must follow the name of a member",
        "expected `,` or `}`" => "a comma or a closing brace must follow",
        "expected `,` or `]`" => "a comma or a closing bracket must follow",
        "recursion limit exceeded" => "lists and objects are nested too deeply",
        "invalid escape" => "a text has a backslash that begins nothing known to JSON",
        "lone leading surrogate in hex escape" | "unexpected end of hex escape" => {
            "a text has one half of a character behind \\u; write both halves, such as \
             \\ud83c\\udfe0, or the character itself"
        }
        "invalid unicode code point" => "a text has bytes that are no UTF-8",
        said if said.starts_with("EOF while parsing") => {
            "the body ends before all that was opened is closed"
        }
        said if said.starts_with("control character") => {
            "a text holds a line break or another control character; write it with a backslash"
        }
        _ => return None,
    })
}

/// What is wanted.
fn thing(wanted: &str) -> &str {
    match wanted {
        "f64" | "f32" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number",
        "a boolean" => "true or false",
        "a string" | "str" => "a text",
        "a map" => "an object",
        "a sequence" => "a list",
        wanted if wanted.starts_with("struct ") => "an object",
        wanted => wanted,
    }
}

/// What was found.
fn value(found: &str) -> Cow<'_, str> {
    match found {
        "map" => "an object".into(),
        "sequence" => "a list".into(),
        _ => match found.strip_prefix("string \"") {
            Some(text) => {
                let text = text.strip_suffix('"').unwrap_or(text);
                format!("the text \"{}\"", shortened(text)).into()
            }
            None => quoted(found).first().map_or(found, |value| value).into(),
        },
    }
}

fn shortened(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn names_are_shortened_and_what_is_not_known_is_left() {
        let long = "x".repeat(1_000);
        let told = plain(
            &format!("unknown field `{long}`, expected `a` or `b`"),
            &long,
        );
        let short = "x".repeat(40);
        assert_eq!(
            told,
            format!("the body has no member {short}…; it has a, b")
        );
        let told = plain("unknown field `b`, there are no fields", "a.b");
        assert_eq!(told, "a has no member b, as it has none");
        assert_eq!(plain("far must be near", "lod"), "far must be near");
        let told = plain("invalid unicode code point", "a");
        assert_eq!(told, "at a: a text has bytes that are no UTF-8");
        let told = plain(&format!("invalid type: string {long:?}, expected f64"), "a");
        assert_eq!(
            told,
            format!("a must be a number, and is the text \"{short}…\"")
        );
    }
}
