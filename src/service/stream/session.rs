//! What a stream knows: what the client said last, and which objects it holds.

use std::mem;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use serde::{Serialize, Serializer};

use super::super::config::Config;
use super::super::metrics::StreamMetrics;
use super::super::problem::{Kind, Problem};
use super::super::scenes::City;
use super::super::visible::request::{Form, Output, Request};
use super::super::visible::{Lists, Naming, Resolved, Tail, size_of_ranges, with_frame};
use super::feedback::steered;
use super::message::{self, Message};
use crate::control::State;
use crate::frame::Frame;
use crate::lod::difference;

/// The state of one stream.
#[derive(Debug)]
pub struct Session {
    city: Arc<City>,
    /// All that holds now.
    standing: Standing,
    /// `seq` of the last message that was not refused.
    seq: u32,
    /// What waits to be answered: of messages, only the newest.
    due: Option<Due>,
    /// Likewise of refusals.
    refusal: Option<Refusal>,
    /// What the client holds.
    held: Vec<Range<u32>>,
    /// Memory of the last difference.
    add: Vec<Range<u32>>,
    remove: Vec<Range<u32>>,
}

/// What the messages so far came to.
#[derive(Debug, Clone, Default)]
struct Standing {
    /// `None` before the first message that was not refused.
    said: Option<Request>,
    /// The controller, once there was feedback.
    control: Option<State>,
    /// The `far_dist` that it chose for the last message, m, if that brought feedback.
    far_dist: Option<f64>,
}

#[derive(Debug)]
struct Due {
    asked: Resolved,
    arrived: Instant,
    /// What held before, should this be refused after all.
    before: Standing,
}

/// A message that changes nothing.
#[derive(Debug, Serialize)]
struct Refusal {
    seq: Option<u32>,
    problem: Problem,
}

#[derive(Serialize)]
struct Answer<'a> {
    seq: u32,
    revision: &'a str,
    count: u32,
    #[serde(serialize_with = "pairs")]
    add: &'a [Range<u32>],
    #[serde(serialize_with = "pairs")]
    remove: &'a [Range<u32>],
    #[serde(flatten)]
    tail: Tail<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    feedback: Option<Chosen>,
}

#[derive(Serialize)]
struct Chosen {
    far_dist_m: f64,
}

fn pairs<S: Serializer>(ranges: &[Range<u32>], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(ranges.iter().map(|range| [range.start, range.end]))
}

impl Session {
    /// Begins with nothing said and nothing held.
    pub fn new(city: Arc<City>) -> Self {
        Self {
            city,
            standing: Standing::default(),
            seq: 0,
            due: None,
            refusal: None,
            held: Vec::new(),
            add: Vec::new(),
            remove: Vec::new(),
        }
    }

    /// Takes in a message that has just arrived.
    pub fn hear(&mut self, text: &str, metrics: &StreamMetrics) {
        metrics.messages.add(1);
        let heard = message::read(text).and_then(|message| {
            let seq = Some(message.seq.0);
            self.understand(message).map_err(|problem| (seq, problem))
        });
        match heard {
            Ok(due) => {
                if self.due.replace(due).is_some() {
                    metrics.skipped.add(1);
                }
            }
            Err((seq, problem)) => {
                metrics.refused.add(1);
                self.refusal = Some(Refusal { seq, problem });
            }
        }
    }

    /// Puts what the message says over what was said before.
    fn understand(&mut self, message: Message) -> Result<Due, Problem> {
        let said = match (&self.standing.said, message.camera) {
            (None, None) => {
                let detail = "missing: the first message tells where it is seen from";
                return Err(Problem::new(Kind::InvalidRequest, detail).at("/camera"));
            }
            (None, Some(camera)) => Request {
                camera,
                lod: message.lod.unwrap_or_default(),
                effects: message.effects.unwrap_or_default(),
                feedback: None,
                output: Output { form: Form::Ranges },
            },
            (Some(before), camera) => Request {
                camera: camera.unwrap_or_else(|| before.camera.clone()),
                lod: message.lod.unwrap_or_else(|| before.lod.clone()),
                effects: message.effects.unwrap_or_else(|| before.effects.clone()),
                feedback: None,
                output: before.output.clone(),
            },
        };
        let mut asked = self.resolve(&said)?;
        let mut standing = Standing {
            said: Some(said),
            control: self.standing.control,
            far_dist: None,
        };
        if let Some(feedback) = message.feedback {
            let (state, far_dist) = feedback.steer(&asked.lod, standing.control.as_ref())?;
            asked.lod = steered(&asked.lod, far_dist);
            standing.control = Some(state);
            standing.far_dist = Some(far_dist);
        }
        self.seq = message.seq.0;
        Ok(Due {
            asked,
            arrived: Instant::now(),
            before: mem::replace(&mut self.standing, standing),
        })
    }

    fn resolve(&self, said: &Request) -> Result<Resolved, Problem> {
        said.check_lists(false, false, Naming::Pointer)?;
        said.resolve(self.city.tree().effects(), Naming::Pointer)
    }

    /// From now on the objects are those of this city. The client holds none of them, and the
    /// last message is answered once more.
    pub fn move_to(&mut self, city: Arc<City>) {
        if Arc::ptr_eq(&self.city, &city) {
            return;
        }
        self.city = city;
        self.held.clear();
        let Some(said) = &self.standing.said else {
            return;
        };
        self.due = None;
        match self.resolve(said) {
            Ok(mut asked) => {
                if let Some(far_dist) = self.standing.far_dist {
                    asked.lod = steered(&asked.lod, far_dist);
                }
                self.due = Some(Due {
                    asked,
                    arrived: Instant::now(),
                    before: self.standing.clone(),
                });
            }
            Err(problem) => {
                let seq = Some(self.seq);
                self.refusal = Some(Refusal { seq, problem });
            }
        }
    }

    /// What is to be sent now, if anything is.
    pub fn next(&mut self, config: &Config, metrics: &StreamMetrics) -> Option<String> {
        if let Some(refusal) = self.refusal.take() {
            return serde_json::to_string(&refusal).ok();
        }
        let due = self.due.take()?;
        let city = Arc::clone(&self.city);
        let answer = with_frame(&city, &due.asked, config, |frame| {
            self.answer(frame, config.max_answer_objects, metrics)
        });
        match answer {
            Ok(text) => {
                metrics.answers.observe(due.arrived.elapsed());
                Some(text)
            }
            Err(problem) => {
                metrics.refused.add(1);
                self.standing = due.before;
                let seq = Some(self.seq);
                serde_json::to_string(&Refusal { seq, problem }).ok()
            }
        }
    }

    /// What leads from what the client holds to this frame, which it holds from then on.
    fn answer(
        &mut self,
        frame: &Frame,
        most_ranges: u32,
        metrics: &StreamMetrics,
    ) -> Result<String, Problem> {
        let selection = frame.selection();
        difference(selection.ranges(), &self.held, &mut self.add);
        difference(&self.held, selection.ranges(), &mut self.remove);
        size_of_ranges(self.add.len() + self.remove.len(), selection, most_ranges)?;
        self.held.clear();
        self.held.extend_from_slice(selection.ranges());
        for (counter, ranges) in metrics.moved.iter().zip([&self.add, &self.remove]) {
            counter.add(ranges.iter().map(|range| range.len() as u64).sum());
        }
        let answer = Answer {
            seq: self.seq,
            revision: self.city.revision(),
            count: selection.count(),
            add: &self.add,
            remove: &self.remove,
            tail: Tail::of(frame, Lists::default()),
            feedback: self
                .standing
                .far_dist
                .map(|far_dist_m| Chosen { far_dist_m }),
        };
        serde_json::to_string(&answer).map_err(|error| {
            // Numbers and strings into memory: there is nothing to fail.
            Problem::new(Kind::Internal, error.to_string())
        })
    }
}
