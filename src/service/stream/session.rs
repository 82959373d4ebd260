//! What a stream knows: what the client said last, and which objects it holds.

use std::mem;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::super::config::Config;
use super::super::metrics::StreamMetrics;
use super::super::problem::{Kind, Problem};
use super::super::scenes::City;
use super::super::visible::request::{Form, Output, Request};
use super::super::visible::{Lists, Naming, Resolved, Tail, size_of_ranges, with_frame};
use super::answer::{self, Answer, Chosen, Members};
use super::feedback::steered;
use super::message::{self, Message};
use crate::control::State;
use crate::frame::Frame;
use crate::lod::difference;

/// After a frame that took so long the next one is taken for dear too.
const DEAR: Duration = Duration::from_millis(1);

/// The state of one stream.
#[derive(Debug)]
pub struct Session {
    city: Arc<City>,
    /// All that holds now.
    standing: Standing,
    /// What waits to be answered: of messages, only the newest.
    due: Option<Due>,
    /// Likewise of refusals.
    refused: Option<Refused>,
    /// What the client was told of this city; `None` before the first answer.
    told: Option<Told>,
    /// Memory of the last difference.
    add: Vec<Range<u32>>,
    remove: Vec<Range<u32>>,
    /// What the last frame took.
    took: Duration,
}

/// What the messages so far came to: of those that were not refused.
#[derive(Debug, Clone, Default)]
struct Standing {
    /// `None` before the first message.
    said: Option<Request>,
    /// Of the last message.
    seq: u32,
    /// The controller, once there was feedback.
    control: Option<State>,
    /// The `far_dist` that it chose for the last message, m, if that brought feedback.
    far_dist: Option<f64>,
    /// Whether each answer tells what it took.
    stats: bool,
}

#[derive(Debug)]
struct Due {
    asked: Resolved,
    arrived: Instant,
    /// What held before, should this be refused after all.
    before: Standing,
}

/// A message that changes nothing.
#[derive(Debug)]
struct Refused {
    seq: Option<u32>,
    problem: Problem,
}

#[derive(Debug)]
struct Told {
    /// What the client holds.
    held: Vec<Range<u32>>,
    members: Members,
}

#[derive(Serialize)]
struct Refusal<'a> {
    seq: Option<u32>,
    /// Where the client does not know it: what it holds is void.
    #[serde(skip_serializing_if = "Option::is_none")]
    revision: Option<&'a str>,
    problem: &'a Problem,
}

impl Session {
    /// Begins with nothing said and nothing held.
    pub fn new(city: Arc<City>) -> Self {
        Self {
            city,
            standing: Standing::default(),
            due: None,
            refused: None,
            told: None,
            add: Vec::new(),
            remove: Vec::new(),
            took: Duration::ZERO,
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
            Err((seq, problem)) => self.refuse(seq, problem, metrics),
        }
    }

    fn refuse(&mut self, seq: Option<u32>, problem: Problem, metrics: &StreamMetrics) {
        metrics.refused.add(1);
        tracing::debug!(seq, reason = problem.reason(), "message refused");
        self.refused = Some(Refused { seq, problem });
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
            seq: message.seq.0,
            control: self.standing.control,
            far_dist: None,
            stats: message.stats.unwrap_or(self.standing.stats),
        };
        if let Some(feedback) = message.feedback {
            let (state, far_dist) = feedback.steer(&asked.lod, standing.control.as_ref())?;
            asked.lod = steered(&asked.lod, far_dist);
            standing.control = Some(state);
            standing.far_dist = Some(far_dist);
        }
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
    pub fn move_to(&mut self, city: Arc<City>, metrics: &StreamMetrics) {
        if Arc::ptr_eq(&self.city, &city) {
            return;
        }
        self.city = city;
        self.told = None;
        let Some(said) = &self.standing.said else {
            return;
        };
        let asked = self.resolve(said);
        // Of a message that waits still, what held before it.
        let waiting = self.due.take().map(|due| due.before);
        let before = waiting.unwrap_or_else(|| self.standing.clone());
        match asked {
            Ok(mut asked) => {
                if let Some(far_dist) = self.standing.far_dist {
                    asked.lod = steered(&asked.lod, far_dist);
                }
                self.due = Some(Due {
                    asked,
                    arrived: Instant::now(),
                    before,
                });
            }
            Err(problem) => {
                let refused = mem::replace(&mut self.standing, before);
                self.refuse(Some(refused.seq), problem, metrics);
            }
        }
    }

    /// Whether [`Session::next`] may take long.
    pub fn is_dear(&self) -> bool {
        let due = self.due.as_ref().filter(|_| self.refused.is_none());
        due.is_some_and(|due| due.asked.is_dear() || self.took >= DEAR)
    }

    /// What is to be sent now, if anything is.
    pub fn next(&mut self, config: &Config, metrics: &StreamMetrics) -> Option<String> {
        if let Some(refused) = self.refused.take() {
            return self.refusal(&refused);
        }
        let due = self.due.take()?;
        let begun = Instant::now();
        let city = Arc::clone(&self.city);
        let answer = with_frame(&city, &due.asked, config, |frame| {
            self.answer(frame, config.max_answer_objects, metrics)
        });
        self.took = begun.elapsed();
        match answer {
            Ok(text) => {
                metrics.answers.observe(due.arrived.elapsed());
                Some(text)
            }
            Err(problem) => {
                let refused = mem::replace(&mut self.standing, due.before);
                self.refuse(Some(refused.seq), problem, metrics);
                self.next(config, metrics)
            }
        }
    }

    fn refusal(&self, refused: &Refused) -> Option<String> {
        let refusal = Refusal {
            seq: refused.seq,
            revision: self.told.is_none().then(|| self.city.revision()),
            problem: &refused.problem,
        };
        answer::text(&refusal).ok()
    }

    /// What leads from what the client holds to this frame, which it holds from then on.
    fn answer(
        &mut self,
        frame: &Frame,
        most_ranges: u32,
        metrics: &StreamMetrics,
    ) -> Result<String, Problem> {
        let selection = frame.selection();
        let before = self.told.as_ref();
        let held = before.map_or(&[][..], |told| &told.held);
        difference(selection.ranges(), held, &mut self.add);
        difference(held, selection.ranges(), &mut self.remove);
        size_of_ranges(self.add.len() + self.remove.len(), selection, most_ranges)?;
        let members = Members::of(&Tail::of(frame, Lists::default()))?;
        let Standing {
            seq,
            far_dist,
            stats,
            ..
        } = self.standing;
        let text = answer::text(&Answer {
            seq,
            revision: before.is_none().then(|| self.city.revision()),
            count: selection.count(),
            add: &self.add,
            remove: &self.remove,
            news: members.news(before.map(|told| &told.members), stats),
            feedback: far_dist.map(|far_dist_m| Chosen { far_dist_m }),
        })?;
        for (counter, ranges) in metrics.moved.iter().zip([&self.add, &self.remove]) {
            counter.add(ranges.iter().map(|range| range.len() as u64).sum());
        }
        let mut held = self.told.take().map(|told| told.held).unwrap_or_default();
        held.clear();
        held.extend_from_slice(selection.ranges());
        self.told = Some(Told { held, members });
        Ok(text)
    }
}
