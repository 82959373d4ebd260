//! The `citylod` command.
fn main() {}
