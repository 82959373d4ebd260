//! The service as a process.

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, ensure};

/// `citylod serve`, killed when dropped.
pub struct Served {
    child: Child,
    address: SocketAddr,
}

impl Served {
    /// Starts it and waits until it listens.
    pub fn start(command: &Path, listen: &str, city: &Path, streams: u32) -> Result<Self> {
        let mut child = Command::new(command)
            .args(["serve", "--listen", listen, "--max-streams"])
            .arg((streams + 16).to_string())
            .arg(city)
            .env("RUST_LOG", "info")
            .stderr(Stdio::piped())
            .spawn()
            .with_context(|| command.display().to_string())?;
        let stderr = child.stderr.take().context("no standard error")?;
        let mut lines = BufReader::new(stderr).lines();
        let address = loop {
            let line = lines.next().context("the service ended")??;
            if let Some((_, address)) = line.split_once("http://") {
                break address.trim().parse()?;
            }
        };
        // What goes wrong there is worth seeing; what is refused was meant to be.
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                if line.contains("ERROR") || line.contains("WARN") || line.contains("panicked") {
                    eprintln!("service: {line}");
                }
            }
        });
        Ok(Self { child, address })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Number of the process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Has the city read again.
    pub fn hang_up(&self) -> Result<()> {
        self.signal("-HUP")
    }

    /// Ends it without a word.
    pub fn kill(&mut self) -> Result<()> {
        self.child.kill()?;
        self.child.wait()?;
        Ok(())
    }

    /// Tells it to stop, and gives its code.
    pub fn stop(&mut self) -> Result<Option<i32>> {
        self.signal("-TERM")?;
        Ok(self.child.wait()?.code())
    }

    fn signal(&self, name: &str) -> Result<()> {
        let id = self.id().to_string();
        let sent = Command::new("kill").args([name, &id]).status()?;
        ensure!(sent.success(), "cannot send {name}");
        Ok(())
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
