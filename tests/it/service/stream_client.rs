use std::collections::BTreeSet;
use std::net::TcpStream;
use std::time::Duration;

use citylod::frame::{Active, Culling, Frame};
use citylod::geom::{DVec3, DepthRange, Orientation, Projection, View};
use citylod::index::{LodTree, Promotion, build};
use citylod::lod::{Beyond, BudgetLod, ErrorLod, Lod, RangeLod};
use citylod::scene::{CityParams, generate};
use citylod::service::Scenes;
use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::{self, Message, WebSocket};

use super::server::{Reply, Running};

/// A client as the description has it: it begins with nothing, adds and removes.
pub struct Client {
    socket: WebSocket<TcpStream>,
    held: BTreeSet<u32>,
    revision: Value,
    lod: Value,
    effects: Value,
    seq: u64,
    last: String,
}

impl Client {
    pub fn open(service: &Running, scene: &str) -> Self {
        Self::try_open(service, scene).expect("a stream")
    }

    pub fn try_open(service: &Running, scene: &str) -> Option<Self> {
        let (socket, _) = connect(service, scene).ok()?;
        Some(Self {
            socket,
            held: BTreeSet::new(),
            revision: Value::Null,
            lod: Value::Null,
            effects: Value::Null,
            seq: 0,
            last: String::new(),
        })
    }

    /// What comes instead of a stream.
    pub fn refused(service: &Running, scene: &str) -> Reply {
        match connect(service, scene) {
            Err(tungstenite::Error::Http(response)) => Reply {
                status: response.status().as_u16(),
                headers: response
                    .headers()
                    .iter()
                    .map(|(name, value)| (name.to_string(), value.to_str().unwrap().to_owned()))
                    .collect(),
                body: Vec::new(),
            },
            other => panic!("not refused: {other:?}"),
        }
    }

    pub fn socket(&mut self) -> &mut WebSocket<TcpStream> {
        &mut self.socket
    }

    /// The objects that it draws.
    pub fn held(&self) -> &BTreeSet<u32> {
        &self.held
    }

    /// `seq` of the last message sent.
    pub fn seq(&self) -> u64 {
        self.seq
    }

    /// The last answer as it came.
    pub fn last(&self) -> &str {
        &self.last
    }

    /// Sends a message, numbered, and waits for its answer.
    pub fn ask(&mut self, message: &Value) -> Value {
        self.send(message);
        let answer = self.receive();
        assert_eq!(answer["seq"], self.seq, "{answer}");
        answer
    }

    pub fn send(&mut self, message: &Value) {
        self.seq += 1;
        let mut message = message.clone();
        message["seq"] = self.seq.into();
        self.send_text(&message.to_string());
    }

    pub fn send_text(&mut self, text: &str) {
        self.socket.send(Message::text(text)).unwrap();
    }

    /// The next answer, carried out, with what it leaves out since it is as before.
    pub fn receive(&mut self) -> Value {
        loop {
            match self.socket.read().unwrap() {
                Message::Text(text) => {
                    text.as_str().clone_into(&mut self.last);
                    let mut answer: Value = serde_json::from_str(&text).unwrap();
                    if let Some(revision) = answer.get("revision") {
                        self.revision = revision.clone();
                        self.held.clear();
                    }
                    if answer["problem"].is_null() {
                        self.carry_out(&answer);
                        self.fill_in(&mut answer);
                    }
                    return answer;
                }
                Message::Ping(_) => self.socket.flush().unwrap(),
                other => panic!("{other:?}"),
            }
        }
    }

    fn carry_out(&mut self, answer: &Value) {
        let ranges = |name: &str| -> Vec<[u32; 2]> {
            let ranges: Vec<[u32; 2]> = serde_json::from_value(answer[name].clone()).unwrap();
            assert!(ranges.iter().all(|[start, end]| start < end), "{answer}");
            assert!(
                ranges.windows(2).all(|pair| pair[0][1] < pair[1][0]),
                "{answer}"
            );
            ranges
        };
        for object in ranges("remove").iter().flat_map(|r| r[0]..r[1]) {
            assert!(self.held.remove(&object), "{object} was never added");
        }
        for object in ranges("add").iter().flat_map(|r| r[0]..r[1]) {
            assert!(self.held.insert(object), "{object} is there already");
        }
        assert_eq!(answer["count"], self.held.len());
    }

    fn fill_in(&mut self, answer: &mut Value) {
        answer["revision"] = self.revision.clone();
        let lod = answer["lod"].as_object().unwrap();
        assert!(lod.contains_key("error_px"), "{answer}");
        if lod.contains_key("mode") {
            self.lod = json!({});
        }
        self.lod.as_object_mut().unwrap().extend(lod.clone());
        answer["lod"] = self.lod.clone();
        if let Some(effects) = answer.get("effects") {
            self.effects = effects.clone();
        }
        answer["effects"] = self.effects.clone();
    }

    /// Reads on until the service closes, and gives its reason.
    pub fn closed(&mut self) -> (CloseCode, String) {
        loop {
            match self.socket.read() {
                Ok(Message::Close(Some(frame))) => {
                    let _ = self.socket.flush();
                    return (frame.code, frame.reason.to_string());
                }
                Ok(Message::Close(None)) | Err(_) => panic!("closed without a reason"),
                Ok(_) => {}
            }
        }
    }
}

fn connect(
    service: &Running,
    scene: &str,
) -> Result<
    (
        WebSocket<TcpStream>,
        tungstenite::handshake::client::Response,
    ),
    tungstenite::Error,
> {
    let stream = TcpStream::connect(service.address).unwrap();
    let patience = Some(Duration::from_secs(20));
    stream.set_read_timeout(patience).unwrap();
    stream.set_nodelay(true).unwrap();
    let url = format!("ws://{}/collections/{scene}/stream", service.address);
    let request = url.into_client_request().unwrap();
    tungstenite::client(request, stream).map_err(|error| match error {
        tungstenite::HandshakeError::Failure(error) => error,
        tungstenite::HandshakeError::Interrupted(_) => panic!("no answer"),
    })
}

/// The full answer to a request, from the library.
pub struct Full<'a> {
    tree: &'a LodTree,
    frame: Frame,
    objects: BTreeSet<u32>,
}

impl<'a> Full<'a> {
    pub fn new(tree: &'a LodTree) -> Self {
        Self {
            tree,
            frame: Frame::default(),
            objects: BTreeSet::new(),
        }
    }

    /// What a camera of eye and target, with all else by default, sees with these knobs.
    pub fn objects(&mut self, request: &Value) -> &BTreeSet<u32> {
        let camera = &request["camera"];
        let point =
            |name: &str| DVec3::from_array(serde_json::from_value(camera[name].clone()).unwrap());
        let view = View::new(
            point("eye"),
            Orientation::LookAt {
                target: point("target"),
                up: DVec3::Z,
            },
            Projection::Perspective { fov_y_deg: 60.0 },
            DepthRange::default(),
            [1920, 1080],
        )
        .unwrap();
        let lod = &request["lod"];
        let knobs = match lod["mode"].as_str() {
            Some("error") => {
                Lod::Error(ErrorLod::new(lod["max_error_px"].as_f64().unwrap()).unwrap())
            }
            Some("budget") => {
                Lod::Budget(BudgetLod::new(lod["max_objects"].as_u64().unwrap() as u32))
            }
            _ => {
                let far_dist = match lod.get("far_dist_m") {
                    None => 500.0,
                    Some(far_dist) => far_dist.as_f64().unwrap_or(f64::INFINITY),
                };
                Lod::Range(RangeLod::new(far_dist, 2.5, 4, Beyond::Show).unwrap())
            }
        };
        let active = Active {
            culling: match lod["culling"].as_str() {
                Some("exact") => Culling::Exact,
                _ => Culling::Fast,
            },
            ..Active::default()
        };
        self.frame
            .work_out(self.tree, &view, &knobs, &active, || Duration::ZERO);
        self.objects = self.frame.selection().objects().collect();
        &self.objects
    }
}

/// A camera, all else by default.
pub fn camera(eye: [f64; 3], target: [f64; 3]) -> Value {
    json!({"eye": eye, "target": target})
}

/// A request worth asking.
pub fn over_the_city() -> Value {
    json!({"camera": camera([0.0, -800.0, 300.0], [0.0, 0.0, 0.0])})
}

/// One scene, `demo`.
pub fn scenes(tree: LodTree) -> Scenes {
    let mut scenes = Scenes::new();
    scenes.insert("demo", tree).unwrap();
    scenes
}

/// A city that is not the usual one.
pub fn other_city(seed: u64) -> LodTree {
    let params = CityParams {
        objects: 2_500,
        seed,
    };
    let scene = generate(&params);
    build(&scene, Promotion::Tallest).unwrap()
}
