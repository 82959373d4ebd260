use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

const CITYLOD: &str = env!("CARGO_BIN_EXE_citylod");

struct Served(Child);

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn python_agrees(city: &Path) {
    let serve = Command::new(CITYLOD)
        .args(["serve", "--listen", "127.0.0.1:0"])
        .arg(city)
        .stderr(Stdio::piped())
        .spawn();
    let mut served = Served(serve.unwrap());
    let mut greeting = BufReader::new(served.0.stderr.take().unwrap()).lines();
    let address = greeting
        .find_map(|line| {
            let line = line.unwrap();
            Some(line.split_once("http://")?.1.trim().to_owned())
        })
        .unwrap();
    let name = city.file_stem().unwrap().to_string_lossy();
    let python = Command::new("python3")
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/oracle.py"))
        .args([CITYLOD.as_ref(), city.as_os_str()])
        .arg(format!("http://{address}/collections/{name}"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&python.stderr);
    assert!(python.status.success(), "{}: {said}", city.display());
    print!("{name}: {}", String::from_utf8_lossy(&python.stdout));
}

/// The ids served over HTTP are those that a program in another language, which shares no code
/// with this one, works out by brute force and by the seven steps: for a made-up city, and for
/// Tokyo-Minato where it is at hand.
#[test]
fn http_answers_are_what_python_works_out() {
    if Command::new("python3").arg("--version").output().is_err() {
        println!("skipped: python3 is not installed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let made = |arguments: &[&str], name: &str| {
        let city = folder.path().join(name);
        let run = Command::new(CITYLOD)
            .args(arguments)
            .arg("-o")
            .arg(&city)
            .output();
        assert!(run.unwrap().status.success());
        city
    };
    python_agrees(&made(&["generate", "--objects", "4000"], "made-up.citylod"));
    match std::env::var("CITYLOD_DATA") {
        Ok(data) => {
            let minato = format!("{data}/cityjson/tokyo-minato-23951.city.json.gz");
            python_agrees(&made(&["import", &minato], "minato.citylod"));
        }
        Err(_) => println!("skipped for Tokyo-Minato: CITYLOD_DATA is not set"),
    }
}
