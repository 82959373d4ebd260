//! From what was asked to a checked view and checked knobs: one of each alternative, and values
//! that can be.

use super::super::problem::{Kind, Problem};
use super::request::{Camera, Form, Lod, Mode, Output, Request};
use crate::frame::{Active, Culling};
use crate::geom::{DMat4, DQuat, DVec3, DepthRange, Orientation, Projection, View};
use crate::lod::{self, BudgetLod, ErrorLod, LodError, RangeLod};
use crate::scene;

/// A frame to work out: values that can be.
#[derive(Debug, Clone)]
pub struct Resolved {
    pub view: View,
    pub lod: lod::Lod,
    /// Of the effects that the scene declares, those of the frame.
    pub active: Active,
}

impl Resolved {
    /// Whether working it out takes long, however little is drawn.
    pub fn is_dear(&self) -> bool {
        let Active {
            occlusion,
            terrain,
            culling,
            ..
        } = &self.active;
        occlusion.is_some() || terrain.is_some() || *culling == Culling::Exact
    }
}

/// How members are named in problems.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Naming {
    /// `/camera/eye`, in a body.
    Pointer,
    /// `eye`, in a query.
    Parameter,
}

impl Naming {
    pub fn problem(self, group: &str, member: &str, detail: impl Into<String>) -> Problem {
        let place = match self {
            Self::Pointer => format!("/{group}/{member}"),
            Self::Parameter => member.split('/').next().unwrap_or_default().to_owned(),
        };
        Problem::new(Kind::ImpossibleValue, detail).at(place)
    }
}

impl Naming {
    /// A setting of an effect: `/effects/motion/speed_mps` in a body, `speed_mps` in a query.
    pub fn setting(self, member: &str, detail: impl Into<String>) -> Problem {
        match (self, member.rsplit_once('/')) {
            (Self::Parameter, Some((_, setting))) => self.problem("effects", setting, detail),
            _ => self.problem("effects", member, detail),
        }
    }
}

impl Request {
    /// The view, the knobs and, of the effects that the scene declares, those of the frame.
    ///
    /// # Errors
    /// 422 for alternatives that exclude each other or are all missing, and for values that
    /// cannot be.
    pub fn resolve(&self, declared: &scene::Effects, naming: Naming) -> Result<Resolved, Problem> {
        let view = self.camera.view(naming)?;
        let lod = self.lod.knobs(naming)?;
        let active = Active {
            culling: self.lod.culling,
            ..self.effects.active(declared, naming)?
        };
        Ok(Resolved { view, lod, active })
    }
}

impl Camera {
    fn view(&self, naming: Naming) -> Result<View, Problem> {
        self.exclude(naming)?;
        let eye = DVec3::from_array(self.eye.0);
        let viewport = self
            .viewport
            .map_or([1920, 1080], |v| v.0.map(|side| side.0));
        let view = if let Some(matrix) = &self.view_projection {
            View::from_matrix(DMat4::from_cols_array(&matrix.0), eye, viewport)
        } else {
            let depth = DepthRange {
                near: self.near.unwrap_or(0.1),
                far: self.far.flatten(),
            };
            let orientation = self.orientation(naming)?;
            let looking =
                |orientation| View::new(eye, orientation, self.projection(), depth, viewport);
            match (looking(orientation), orientation) {
                // Straight up or down: north appears upright, unless something else is asked for.
                (Err(error), Orientation::LookAt { target, .. })
                    if error.field == "up" && self.up.is_none() =>
                {
                    let up = DVec3::Y;
                    looking(Orientation::LookAt { target, up })
                }
                (view, _) => view,
            }
        };
        view.map_err(|error| {
            let member = match error.field {
                "left" => "off_axis/0",
                "bottom" => "off_axis/2",
                field => field,
            };
            let detail = match member {
                "up" => format!("{}: give another, such as [0,1,0]", error.reason),
                _ => error.reason,
            };
            naming.problem("camera", member, detail)
        })
    }

    /// Refuses members that would overrule each other.
    fn exclude(&self, naming: Naming) -> Result<(), Problem> {
        let target = ("target", self.target.is_some());
        let up = ("up", self.up.is_some());
        let quaternion = ("quaternion", self.quaternion.is_some());
        let fov = ("fov_y_deg", self.fov_y_deg.is_some());
        let orthographic = (
            "orthographic_height_m",
            self.orthographic_height_m.is_some(),
        );
        let off_axis = ("off_axis", self.off_axis.is_some());
        let near = ("near", self.near.is_some());
        let far = ("far", self.far.is_some());
        let matrix = ("view_projection", self.view_projection.is_some());
        let rivals = [
            (quaternion, &[target, up][..]),
            (orthographic, &[fov]),
            (off_axis, &[fov, orthographic]),
            (
                matrix,
                &[
                    target,
                    up,
                    quaternion,
                    fov,
                    orthographic,
                    off_axis,
                    near,
                    far,
                ],
            ),
        ];
        for ((member, given), others) in rivals {
            if let Some((other, _)) = others.iter().find(|(_, also)| given && *also) {
                let detail = format!("cannot stand beside {other}: give one of them");
                return Err(naming.problem("camera", member, detail));
            }
        }
        Ok(())
    }

    fn orientation(&self, naming: Naming) -> Result<Orientation, Problem> {
        match (self.quaternion, self.target) {
            (Some(quaternion), _) => Ok(Orientation::Quaternion(DQuat::from_array(quaternion.0))),
            (None, Some(target)) => Ok(Orientation::LookAt {
                target: DVec3::from_array(target.0),
                up: self.up.map_or(DVec3::Z, |up| DVec3::from_array(up.0)),
            }),
            (None, None) => {
                let detail = "missing: give target, quaternion or view_projection";
                Err(naming.problem("camera", "target", detail))
            }
        }
    }

    fn projection(&self) -> Projection {
        if let Some(height_m) = self.orthographic_height_m {
            return Projection::Orthographic { height_m };
        }
        if let Some(window) = self.off_axis {
            let [left, right, bottom, top] = window.0;
            return Projection::OffAxis {
                left,
                right,
                bottom,
                top,
            };
        }
        Projection::Perspective {
            fov_y_deg: self.fov_y_deg.unwrap_or(60.0),
        }
    }
}

impl Lod {
    fn knobs(&self, naming: Naming) -> Result<lod::Lod, Problem> {
        self.exclude(naming)?;
        let missing = |member, detail| naming.problem("lod", member, detail);
        let lod = match self.mode {
            Mode::Range => self.range().map(lod::Lod::Range),
            Mode::Error => {
                let detail = "missing: the smallest size to draw, pixels";
                let px = self.max_error_px;
                let px = px.ok_or_else(|| missing("max_error_px", detail))?;
                ErrorLod::new(px).map(lod::Lod::Error)
            }
            Mode::Budget => {
                let detail = "missing: how many objects to draw at most";
                let most = self.max_objects;
                let most = most.ok_or_else(|| missing("max_objects", detail))?;
                Ok(lod::Lod::Budget(BudgetLod::new(most.0)))
            }
        };
        lod.map_err(|error| naming.problem("lod", error.field, error.reason))
    }

    fn range(&self) -> Result<RangeLod, LodError> {
        let usual = RangeLod::default();
        RangeLod::new(
            self.far_dist_m
                .map_or(usual.far_dist(), |far| far.unwrap_or(f64::INFINITY)),
            self.dist_factor.unwrap_or(usual.dist_factor()),
            self.levels.map_or(usual.level_count(), |levels| levels.0),
            self.beyond.unwrap_or(usual.beyond()),
        )
    }

    /// Refuses members of other modes.
    fn exclude(&self, naming: Naming) -> Result<(), Problem> {
        let members = [
            (Mode::Range, "far_dist_m", self.far_dist_m.is_some()),
            (Mode::Range, "dist_factor", self.dist_factor.is_some()),
            (Mode::Range, "levels", self.levels.is_some()),
            (Mode::Range, "beyond", self.beyond.is_some()),
            (Mode::Error, "max_error_px", self.max_error_px.is_some()),
            (Mode::Budget, "max_objects", self.max_objects.is_some()),
        ];
        let stray = members
            .iter()
            .find(|(of, _, given)| *given && *of != self.mode);
        stray.map_or(Ok(()), |(of, member, _)| {
            let detail = format!(
                "belongs to mode {:?}, not to {:?}: leave it out or change the mode",
                of.name(),
                self.mode.name()
            );
            Err(naming.problem("lod", member, detail))
        })
    }
}

impl Request {
    /// Refuses pixels beside a list that does not name each object, and patches where there is no
    /// room for them.
    ///
    /// # Errors
    /// 422.
    pub fn check_lists(&self, room: bool, binary: bool, naming: Naming) -> Result<(), Problem> {
        if self.effects.patches() && (binary || !room) {
            let detail = "goes with an answer to GET or POST visible as application/json";
            return Err(naming.setting("terrain/patches", detail));
        }
        if self.effects.visible_pixels() && (binary || self.output.form == Form::Ranges) {
            let detail = "goes with a list of ids or objects as application/json";
            return Err(naming.setting("occlusion/visible_pixels", detail));
        }
        Ok(())
    }
}

impl Output {
    /// Refuses forms that a binary answer cannot have.
    ///
    /// # Errors
    /// 422.
    pub fn check_binary(&self, naming: Naming) -> Result<(), Problem> {
        if self.form == Form::Ids {
            return Ok(());
        }
        let detail = "a binary answer lists object numbers: leave out the form, or accept \
                      application/json";
        Err(naming.problem("output", "form", detail))
    }
}
