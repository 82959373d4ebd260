//! Reads the sources and refuses what the layer table and the house rules forbid.

use std::fs;
use std::path::{Path, PathBuf};

/// The layer table: a module, its layer, and the modules it may use.
const LAYERS: &[(&str, u8, &[&str])] = &[
    ("geom", 0, &[]),
    ("file", 0, &[]),
    ("scene", 1, &["geom"]),
    ("import", 2, &["geom", "scene"]),
    ("index", 2, &["geom", "file", "scene"]),
    ("terrain", 2, &["geom", "file"]),
    ("control", 2, &[]),
    ("lod", 3, &["geom", "index"]),
    ("raster", 3, &["geom", "scene"]),
    ("effects", 4, &["geom", "scene", "lod", "raster", "terrain"]),
    ("frame", 5, ENGINE),
    ("experiment", 6, BELOW_THE_EDGE),
    ("service", 6, BELOW_THE_EDGE),
    ("cli", 7, EVERYTHING),
];
const ENGINE: &[&str] = &[
    "geom", "scene", "index", "terrain", "control", "lod", "raster", "effects",
];
const BELOW_THE_EDGE: &[&str] = &[
    "geom", "file", "scene", "index", "terrain", "control", "lod", "raster", "effects", "frame",
    "import",
];
const EVERYTHING: &[&str] = &[
    "geom",
    "file",
    "scene",
    "index",
    "terrain",
    "control",
    "lod",
    "raster",
    "effects",
    "frame",
    "import",
    "experiment",
    "service",
];

/// What layers 0–5 must not read: clocks, the environment, random sources without a seed.
const OUTSIDE_WORLD: &[&str] = &[
    "Instant",
    "SystemTime",
    "std::env",
    "rand::rng",
    "thread_rng",
    "getrandom",
    "OsRng",
    "SysRng",
    "from_os_rng",
];

/// Unfinished work.
const UNFINISHED: &[&str] = &["TODO", "FIXME", "todo!", "unimplemented!", "#[ignore"];

/// Longer files have two subjects.
const LONGEST_FILE: usize = 400;

/// Everything wrong with one source file; `path` is relative to `src`, with forward slashes.
fn violations(path: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let lines = text.lines().count();
    if lines > LONGEST_FILE {
        found.push(format!("{path}: {lines} lines, more than {LONGEST_FILE}"));
    }
    for mark in UNFINISHED.iter().filter(|mark| text.contains(**mark)) {
        found.push(format!("{path}: `{mark}`"));
    }
    if matches!(path, "lib.rs" | "main.rs") {
        return found;
    }
    let module = path.split(['/', '.']).next().unwrap_or_default();
    let Some(&(_, layer, may_use)) = LAYERS.iter().find(|row| row.0 == module) else {
        found.push(format!(
            "{path}: module `{module}` is not in the layer table"
        ));
        return found;
    };
    let code = code_only(text);
    for used in modules_used(path, &code) {
        if used != module && !may_use.contains(&used.as_str()) {
            found.push(format!("{path}: `{module}` may not use `{used}`"));
        }
    }
    if layer <= 5 {
        for source in OUTSIDE_WORLD.iter().filter(|s| has_word(&code, s)) {
            found.push(format!("{path}: layer {layer} reads `{source}`"));
        }
    }
    found
}

/// The top-level names reached by `crate::…` and by chains of `super::` that end at the root.
fn modules_used(path: &str, code: &str) -> Vec<String> {
    // Spaces and line ends mean nothing inside a path.
    let squeezed = |from: usize| code[from..].chars().filter(|c| !c.is_whitespace());
    let mut used = Vec::new();
    for (at, word) in words(code) {
        let preceded = code[..at].trim_end().ends_with("::");
        let rest: String = match word {
            "crate" => squeezed(at + word.len()).take(600).collect(),
            "super" if !preceded => {
                let chain: String = squeezed(at).take(600).collect();
                let below_super = chain.trim_start_matches("super::");
                let climbed = (chain.len() - below_super.len()) / "super::".len();
                if climbed == 0 || climbed < depth(path) + inline_modules(&code[..at]) {
                    continue;
                }
                format!("::{below_super}")
            }
            _ => continue,
        };
        let Some(names) = rest.strip_prefix("::") else {
            continue; // `pub(crate)`
        };
        used.extend(first_names(names));
    }
    used
}

/// `a::b` gives a; `{a::b, c::{d, e}}` gives a and c.
fn first_names(path: &str) -> Vec<String> {
    let name = |text: &str| -> String { text.chars().take_while(|&c| is_name(c)).collect() };
    let Some(group) = path.strip_prefix('{') else {
        return vec![name(path)];
    };
    let (mut names, mut open, mut start) = (Vec::new(), 0_u32, 0);
    for (at, c) in group.char_indices() {
        match c {
            '{' => open += 1,
            '}' if open > 0 => open -= 1,
            ',' | '}' if open == 0 => {
                names.push(name(&group[start..at]));
                start = at + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    names.retain(|n| !n.is_empty() && n != "self");
    names
}

/// How many `super` lead from the file's own module to the crate root.
fn depth(path: &str) -> usize {
    path.trim_end_matches(".rs")
        .trim_end_matches("/mod")
        .split('/')
        .count()
}

/// How many `mod name { … }` are open at the end of `code`.
fn inline_modules(code: &str) -> usize {
    let mut open = Vec::new();
    let mut since_brace = String::new();
    for c in code.chars() {
        match c {
            '{' => {
                let head: Vec<&str> = since_brace.split_whitespace().collect();
                open.push(matches!(head[..], [.., "mod", _]));
                since_brace.clear();
            }
            '}' => {
                open.pop();
                since_brace.clear();
            }
            ';' => since_brace.clear(),
            _ => since_brace.push(c),
        }
    }
    open.iter().filter(|is_module| **is_module).count()
}

/// The text without comments and without what stands in string literals.
fn code_only(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let raw_hashes = rest
            .strip_prefix('r')
            .map(|r| r.len() - r.trim_start_matches('#').len());
        let opens_raw =
            raw_hashes.filter(|&n| rest[1 + n..].starts_with('"') && !code.ends_with(is_name));
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            end_of_block_comment(rest)
        } else if let Some(hashes) = opens_raw {
            let close = format!("\"{}", "#".repeat(hashes));
            let body = 2 + hashes;
            rest[body..]
                .find(&close)
                .map_or(rest.len(), |at| body + at + close.len())
        } else if c == '"' {
            end_of_string(rest)
        } else if let Some(quoted) = quoted_char(rest) {
            quoted
        } else {
            code.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        };
        code.push(' ');
        rest = &rest[skipped..];
    }
    code
}

fn end_of_block_comment(text: &str) -> usize {
    let (mut open, mut at) = (0_u32, 0);
    while at < text.len() {
        if text[at..].starts_with("/*") {
            (open, at) = (open + 1, at + 2);
        } else if text[at..].starts_with("*/") {
            (open, at) = (open - 1, at + 2);
            if open == 0 {
                break;
            }
        } else {
            at += text[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    at
}

fn end_of_string(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            '"' if !escaped => return at + 1,
            '\\' => escaped = !escaped,
            _ => escaped = false,
        }
    }
    text.len()
}

/// Length of a character literal at the start; `None` for lifetimes and anything else.
fn quoted_char(text: &str) -> Option<usize> {
    let inside = text.strip_prefix('\'')?;
    let first = inside.chars().next()?;
    let from = if first == '\\' { 2 } else { first.len_utf8() };
    let close = inside.get(from..)?.find('\'')?;
    (close == 0 || first == '\\').then_some(1 + from + close + 1)
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn words(code: &str) -> impl Iterator<Item = (usize, &str)> {
    code.split(|c| !is_name(c))
        .filter(|word| !word.is_empty())
        .map(|word| (word.as_ptr() as usize - code.as_ptr() as usize, word))
}

fn has_word(code: &str, word: &str) -> bool {
    code.match_indices(word).any(|(at, _)| {
        !code[..at].ends_with(is_name) && !code[at + word.len()..].starts_with(is_name)
    })
}

/// Names in `mod` lines that no doc sentence stands before.
fn modules_without_a_sentence(text: &str) -> Vec<String> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let mut missing = Vec::new();
    for (n, line) in lines.iter().enumerate() {
        let bare = line.strip_prefix("pub ").unwrap_or(line);
        let Some(name) = bare.strip_prefix("mod ") else {
            continue;
        };
        let above = lines[..n].iter().rev().find(|l| !l.starts_with("#["));
        if !above.is_some_and(|l| l.starts_with("/// ") && l.ends_with('.')) {
            missing.push(name.trim_end_matches(';').to_owned());
        }
    }
    missing
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn sources_keep_the_layers_and_the_house_rules() {
    let src = root().join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    assert!(files.len() > 5, "the walk found only {files:?}");
    files.sort();
    let mut found = Vec::new();
    for file in files {
        let text = fs::read_to_string(&file).expect("UTF-8");
        let relative = file.strip_prefix(&src).expect("below src");
        let path = relative.to_string_lossy().replace('\\', "/");
        found.extend(violations(&path, &text));
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn every_test_module_says_what_it_is_for() {
    let text = fs::read_to_string(root().join("tests/it/main.rs")).expect("UTF-8");
    let missing = modules_without_a_sentence(&text);
    assert!(missing.is_empty(), "no sentence before {missing:?}");
    assert_eq!(
        modules_without_a_sentence("/// Walks.\nmod a;\nmod b;"),
        ["b"]
    );
}

#[test]
fn the_layer_table_points_upward_only() {
    for &(module, layer, may_use) in LAYERS {
        for used in may_use {
            let row = LAYERS
                .iter()
                .find(|row| row.0 == *used)
                .expect("a module of the table");
            assert!(row.1 < layer, "{module} and {used}");
        }
    }
}

#[test]
fn violations_are_seen() {
    let forbidden = [
        ("geom/aabb.rs", "use crate::scene::Scene;"),
        ("geom.rs", "fn f() { super::scene::f() }"),
        (
            "index/file.rs",
            "use crate::{geom::Aabb, lod::{retrieve, Selection}};",
        ),
        (
            "index/file.rs",
            "use crate :: {\n    geom::Aabb,\n    import::Up,\n};",
        ),
        (
            "terrain/tile/store.rs",
            "use super::super::super::index::LodTree;",
        ),
        ("lod/mod.rs", "mod tests { use super::super::effects; }"),
        (
            "service/mod.rs",
            "let s = \"//\"; crate::experiment::run();",
        ),
        (
            "service/mod.rs",
            "let c = '\"'; crate::experiment::run(); let d = '\"';",
        ),
        ("raster/mod.rs", "let s = r#\" \" \"#; crate::lod::f();"),
        ("helpers/mod.rs", ""),
        ("helpers.rs", ""),
        ("lod/mod.rs", "let t = std::time::Instant::now();"),
        ("frame/mod.rs", "std::env::var(\"HOME\");"),
        ("scene/generate.rs", "let mut r = rand::rng();"),
        ("cli/mod.rs", "// TODO"),
        ("main.rs", "fn main() { todo!() }"),
    ];
    for (path, text) in forbidden {
        assert_eq!(violations(path, text).len(), 1, "{path}: {text}");
    }
    let long = "\n".repeat(LONGEST_FILE + 1);
    assert_eq!(violations("lib.rs", &long).len(), 1);
}

#[test]
fn what_is_allowed_is_not_held_against_a_file() {
    let allowed = [
        (
            "lod/mod.rs",
            "//! See [`crate::service`].\n/* crate::cli /* x */ crate::cli */",
        ),
        (
            "lod/mod.rs",
            "use crate::{geom::{Aabb, View}, index::LodTree};\npub(crate) fn f() {}",
        ),
        (
            "lod/range.rs",
            "use super::Selection; mod tests { use super::super::Selection; }",
        ),
        (
            "lod/range.rs",
            "fn f<'a>(x: &'a str) -> char { let s = \"crate::cli\"; 'x' }",
        ),
        (
            "scene/object.rs",
            "use crate::geom::Aabb; use crate::scene::Scene;",
        ),
        ("scene/generate/plan.rs", "let r = Pcg32::seed_from_u64(7);"),
        (
            "service/mod.rs",
            "let t = std::time::Instant::now(); crate::import::f();",
        ),
        ("cli/mod.rs", "use crate::experiment; use crate::service;"),
        ("lib.rs", "pub mod geom; pub use crate::anything;"),
    ];
    for (path, text) in allowed {
        assert_eq!(violations(path, text), [""; 0], "{path}: {text}");
    }
}
