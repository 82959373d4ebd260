use std::path::{Path, PathBuf};
use std::process::Command;

use super::server::Running;

/// From the environment, from `.venv` (where `make test` puts it), or from the path.
fn tool() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let candidates = [
        std::env::var_os("SCHEMATHESIS").map(PathBuf::from),
        Some(root.join(".venv/bin/schemathesis")),
        Some(PathBuf::from("schemathesis")),
    ];
    candidates.into_iter().flatten().find(|tool| {
        let version = Command::new(tool).arg("--version").output();
        version.is_ok_and(|output| output.status.success())
    })
}

#[test]
fn schemathesis_finds_no_failure() {
    let Some(tool) = tool() else {
        eprintln!("skipped: schemathesis is not installed");
        return;
    };
    let service = Running::new();
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::fs::copy(
        root.join("schemathesis.toml"),
        folder.path().join("schemathesis.toml"),
    )
    .unwrap();
    // In a folder of its own, so that what it remembers does not decide what it tries.
    // Method by method: run together, the tool counts one operation too few.
    for method in ["GET", "POST"] {
        let output = Command::new(&tool)
            .current_dir(folder.path())
            .args(["run", "--checks", "all", "--include-method", method])
            .args(["--seed", "1", "--max-examples", "40", "--no-color"])
            .args(["--generation-database", ":memory:"])
            .arg(format!("http://{}/api", service.address))
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "{}{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
    }
    assert_eq!(service.get("/health").status, 200);
}
