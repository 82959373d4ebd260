use std::path::PathBuf;
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

use crate::written::fixture;

/// A folder to run the command in.
pub struct Desk(TempDir);

/// What a run came to.
pub struct Run {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Desk {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the command with these words, none of which holds a space.
    pub fn run(&self, words: &str) -> Run {
        self.run_with(&words.split(' ').map(Into::into).collect::<Vec<_>>())
    }

    fn run_with(&self, arguments: &[PathBuf]) -> Run {
        let output = self.command().args(arguments).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Run {
            code: output.status.code(),
            out: text(output.stdout),
            err: text(output.stderr),
        }
    }

    pub fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_citylod"));
        command.current_dir(self.0.path()).stdin(Stdio::null());
        command
    }

    /// What a run prints that succeeds.
    pub fn out(&self, words: &str) -> String {
        let run = self.run(words);
        assert_eq!(run.code, Some(0), "{words}: {}", run.err);
        run.out
    }

    pub fn json(&self, words: &str) -> Value {
        serde_json::from_str(&self.out(words)).unwrap()
    }

    pub fn lines(&self, words: &str) -> Vec<Value> {
        let out = self.out(words);
        out.lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    }

    /// Imports fixtures into `city.citylod` and gives its objects.
    pub fn imported(&self, files: &[&str], options: &str) -> Vec<Value> {
        let mut words: Vec<PathBuf> = vec!["import".into()];
        words.extend(files.iter().map(|f| fixture(f)));
        words.extend(options.split_whitespace().map(Into::into));
        words.extend(["-o".into(), "city.citylod".into()]);
        let run = self.run_with(&words);
        assert_eq!(run.code, Some(0), "{}", run.err);
        self.lines("info city.citylod --objects")
    }

    pub fn write(&self, name: &str, content: &[u8]) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Asserts that a run fails with this code and these words on its standard error.
    pub fn refuses(&self, words: &str, code: i32, expected: &[&str]) {
        let run = self.run(words);
        assert_eq!(run.code, Some(code), "{words}: {}", run.err);
        assert_eq!(run.out, "", "{words}");
        for word in expected {
            assert!(run.err.contains(word), "{words}: {word:?} in {:?}", run.err);
        }
        assert!(!run.err.contains("panicked"), "{}", run.err);
    }
}
