//! The `citylod` command.

fn main() -> std::process::ExitCode {
    citylod::cli::run()
}
