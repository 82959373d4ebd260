use std::fmt::Write as _;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use citylod::geom::{Aabb, DVec3};
use citylod::index::{self, LodTree, Promotion};
use citylod::scene::{CityParams, Scene, SceneObject, generate};
use citylod::service::{Config, Scenes, Server, Shared, router};
use serde_json::Value;
use serde_json::value::RawValue;
use tokio::sync::oneshot;

/// Ids as cities have them, and as they should not but do.
pub const ODD_IDS: [&str; 6] = [
    "東京タワー",
    "a/b?c=d#e",
    "tab\tquote\"back\\slash",
    "50% & more",
    "🏙️",
    "..",
];

/// A service of its own, stopped when dropped.
pub struct Running {
    pub address: SocketAddr,
    pub shared: Arc<Shared>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Running {
    /// Serves `demo` and `odd ö` with these limits and more routes.
    pub fn with(config: Config, extend: impl FnOnce(axum::Router) -> axum::Router) -> Self {
        let mut scenes = Scenes::new();
        scenes.insert("demo", demo()).unwrap();
        scenes.insert("odd ö", odd()).unwrap();
        scenes.insert("empty", tree(Vec::new())).unwrap();
        Self::of(scenes, config, extend)
    }

    /// Serves these scenes.
    pub fn of(
        scenes: Scenes,
        config: Config,
        extend: impl FnOnce(axum::Router) -> axum::Router,
    ) -> Self {
        let config = Config {
            listen: ([127, 0, 0, 1], 0).into(),
            ..config
        };
        let shared = Shared::new(scenes, &config);
        let app = extend(router(Arc::clone(&shared)));
        let served = Arc::clone(&shared);
        let (stop, stopped) = oneshot::channel::<()>();
        let (tell, told) = std::sync::mpsc::channel();
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_multi_thread()
                .worker_threads(2)
                .enable_all()
                .build()
                .unwrap();
            runtime.block_on(async {
                let server = Server::bind(served, app).await.unwrap();
                tell.send(server.address()).unwrap();
                server
                    .run(async {
                        let _ = stopped.await;
                    })
                    .await;
            });
        });
        Self {
            address: told.recv().unwrap(),
            shared,
            stop: Some(stop),
            thread: Some(thread),
        }
    }

    pub fn new() -> Self {
        Self::with(Config::default(), |app| app)
    }

    /// Tells it to stop, without waiting.
    pub fn stop(&mut self) {
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
    }

    /// Waits until it has.
    pub fn wait(&mut self) {
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }

    pub fn get(&self, path: &str) -> Reply {
        self.send("GET", path, &[], b"")
    }

    pub fn visible(&self, scene: &str, body: &str) -> Reply {
        self.send(
            "POST",
            &format!("/collections/{scene}/visible"),
            &[("Content-Type", "application/json")],
            body.as_bytes(),
        )
    }

    /// One request on a connection of its own.
    pub fn send(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Reply {
        let mut head =
            format!("{method} {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n");
        for (name, value) in headers {
            let _ = write!(head, "{name}: {value}\r\n");
        }
        if !body.is_empty() || method == "POST" {
            let _ = write!(head, "Content-Length: {}\r\n", body.len());
        }
        head.push_str("\r\n");
        self.raw(&[head.as_bytes(), body].concat())
    }

    /// Bytes as they are, on a connection of their own; the server has to end it.
    pub fn raw(&self, bytes: &[u8]) -> Reply {
        let mut stream = self.connect();
        // The server may answer and close before it has read everything.
        let _ = stream.write_all(bytes);
        Reply::read(&mut stream)
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        let patience = Some(Duration::from_secs(20));
        stream.set_read_timeout(patience).unwrap();
        stream
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop();
        self.wait();
    }
}

/// What came back.
#[derive(Debug)]
pub struct Reply {
    pub status: u16,
    pub headers: Vec<(String, String)>,
    pub body: Vec<u8>,
}

impl Reply {
    pub fn read(stream: &mut TcpStream) -> Self {
        let mut bytes = Vec::new();
        // A reset after the answer is no concern of ours.
        let _ = stream.read_to_end(&mut bytes);
        let end = memchr::memmem::find(&bytes, b"\r\n\r\n")
            .unwrap_or_else(|| panic!("no answer: {:?}", String::from_utf8_lossy(&bytes)));
        let head = std::str::from_utf8(&bytes[..end]).unwrap();
        let mut lines = head.split("\r\n");
        let status = lines.next().unwrap().split(' ').nth(1).unwrap();
        let headers: Vec<_> = lines
            .map(|line| line.split_once(": ").unwrap())
            .map(|(name, value)| (name.to_ascii_lowercase(), value.to_owned()))
            .collect();
        let mut reply = Self {
            status: status.parse().unwrap(),
            headers,
            body: bytes[end + 4..].to_vec(),
        };
        if reply.header("transfer-encoding") == Some("chunked") {
            reply.body = unchunked(&reply.body);
        }
        reply
    }

    pub fn header(&self, name: &str) -> Option<&str> {
        let found = self.headers.iter().find(|(have, _)| have == name);
        found.map(|(_, value)| value.as_str())
    }

    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&self.body)))
    }

    /// Asserts that it is a proper problem document.
    pub fn problem(&self, status: u16) -> Value {
        let text = String::from_utf8_lossy(&self.body);
        assert_eq!(self.status, status, "{text}");
        assert_eq!(
            self.header("content-type"),
            Some("application/problem+json"),
            "{text}"
        );
        let document = self.json();
        assert_eq!(document["status"], status);
        for member in ["type", "title", "detail"] {
            assert!(
                document[member].as_str().is_some_and(|t| !t.is_empty()),
                "{member}: {text}"
            );
        }
        document
    }
}

fn unchunked(mut bytes: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    while let Some(end) = memchr::memmem::find(bytes, b"\r\n") {
        let size = std::str::from_utf8(&bytes[..end]).unwrap();
        let size = usize::from_str_radix(size, 16).unwrap();
        if size == 0 {
            break;
        }
        body.extend_from_slice(&bytes[end + 2..end + 2 + size]);
        bytes = &bytes[end + 4 + size..];
    }
    body
}

pub fn demo() -> LodTree {
    let scene = generate(&CityParams {
        objects: 3_000,
        seed: 1,
    });
    index::build(&scene, Promotion::Tallest).unwrap()
}

fn odd() -> LodTree {
    let objects = ODD_IDS.iter().enumerate().map(|(at, &id)| {
        let min = DVec3::new(at as f64 * 20.0, 0.0, 0.0);
        SceneObject {
            id: id.into(),
            class: "Building".into(),
            bounds: Aabb::new(min, min + DVec3::new(10.0, 10.0, 5.0)).unwrap(),
            footprint_area: 100.0,
            triangles: 12,
            base_known: true,
            lift_m: 0.0,
            attributes: (at == 0)
                .then(|| RawValue::from_string(r#"{"height":333,"名":"塔"}"#.into()).unwrap()),
        }
    });
    tree(objects.collect())
}

fn tree(objects: Vec<SceneObject>) -> LodTree {
    let crs = Some("EPSG:6677".into());
    index::build(
        &Scene {
            crs,
            objects,
            ..Scene::default()
        },
        Promotion::Footprint,
    )
    .unwrap()
}
