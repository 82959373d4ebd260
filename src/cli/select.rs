//! What a camera selects in a city, as `query` and `render` need it.

use std::time::Instant;

use anyhow::{Result, bail};

use super::args::{BeyondArg, CullingArg, EffectArg, SelectArgs, misuse};
use super::text;
use crate::frame::{Active, Culling, Frame, Ran};
use crate::geom::{DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;
use crate::lod::{Beyond, BudgetLod, ErrorLod, Lod, LodError, RangeLod};
use crate::scene::Effects;

/// A city, a camera and what it draws.
pub(super) struct Selected {
    pub tree: LodTree,
    pub view: View,
    pub frame: Frame,
}

impl Selected {
    /// Where to look, if the camera misses the city.
    pub(super) fn hint(&self) -> Option<String> {
        let (selection, ran) = (self.frame.selection(), self.frame.effects());
        let removed = |by: Option<Ran<u32>>| by.is_some_and(|ran| ran.result > 0);
        // Whatever is in view and not drawn counts for the bound, or an effect removed it.
        let missed = selection.count() == 0
            && selection.error_px() == 0.0
            && !removed(ran.haze)
            && !removed(ran.occlusion);
        let bounds = self.tree.bounds();
        (missed && !bounds.is_empty()).then(|| {
            format!(
                "nothing of the city is in view: it lies between {} and {}; change --eye or \
                 --target",
                text::point(bounds.min(), ","),
                text::point(bounds.max(), ","),
            )
        })
    }
}

/// Carries out what was typed for `verb`, so many times in the same memory.
pub(super) fn select(args: &SelectArgs, verb: &str, times: u32) -> Result<Selected> {
    let wrong = |field, reason: &str| misuse(verb, format!("{}: {reason}", flag(field)));
    let lod = lod(args).map_err(|e| wrong(e.field, &e.reason))?;
    let view = view(args).map_err(|e| wrong(e.field, &e.reason))?;
    if !(args.speed >= 0.0 && args.speed.is_finite()) {
        let reason = format!("must be 0 or more and finite, is {}", args.speed);
        return Err(wrong("speed_mps", &reason).into());
    }
    let tree = LodTree::open_verified(&args.file)?;
    let active = active(args, tree.effects())?;
    let mut frame = Frame::default();
    let start = Instant::now();
    for _ in 0..times {
        frame.work_out(&tree, &view, &lod, &active, || start.elapsed());
    }
    Ok(Selected { tree, view, frame })
}

/// What the city declares, less what is switched off.
fn active(args: &SelectArgs, declared: &Effects) -> Result<Active> {
    let mut active = Active::all(declared, args.speed);
    active.culling = match args.culling {
        CullingArg::Fast => Culling::Fast,
        CullingArg::Exact => Culling::Exact,
    };
    for effect in &args.without {
        let (name, was_declared) = match effect {
            EffectArg::Motion => ("motion", declared.motion.is_some()),
            EffectArg::Haze => ("haze", declared.haze.is_some()),
            EffectArg::Occlusion => ("occlusion", declared.occlusion.is_some()),
        };
        match effect {
            EffectArg::Motion => active.motion = None,
            EffectArg::Haze => active.haze = None,
            EffectArg::Occlusion => active.occlusion = None,
        }
        if !was_declared {
            bail!(
                "{}: does not declare {name}, so --without {name} has nothing to switch off",
                args.file.display()
            );
        }
    }
    Ok(active)
}

fn lod(args: &SelectArgs) -> Result<Lod, LodError> {
    if let Some(px) = args.max_error_px {
        return ErrorLod::new(px).map(Lod::Error);
    }
    if let Some(most) = args.max_objects {
        return Ok(Lod::Budget(BudgetLod::new(most)));
    }
    let beyond = match args.beyond {
        BeyondArg::Show => Beyond::Show,
        BeyondArg::Hide => Beyond::Hide,
    };
    RangeLod::new(args.far_dist, args.dist_factor, args.levels, beyond).map(Lod::Range)
}

fn view(args: &SelectArgs) -> Result<View, crate::geom::ViewError> {
    let depth = DepthRange {
        near: 0.1,
        far: None,
    };
    let fov_y_deg = args.fov;
    View::new(
        args.eye.0,
        Orientation::LookAt {
            target: args.target.0,
            up: upright(args),
        },
        Projection::Perspective { fov_y_deg },
        depth,
        args.size.0,
    )
}

/// Up, or north where the camera looks straight up or down.
fn upright(args: &SelectArgs) -> DVec3 {
    let sight = args.target.0 - args.eye.0;
    if sight.x == 0.0 && sight.y == 0.0 {
        DVec3::Y
    } else {
        DVec3::Z
    }
}

/// The flag that sets a field of the engine.
fn flag(field: &'static str) -> &'static str {
    match field {
        "eye" => "--eye",
        "target" | "up" => "--target",
        "fov_y_deg" => "--fov",
        "viewport" => "--size",
        "far_dist_m" => "--far-dist",
        "dist_factor" => "--dist-factor",
        "levels" => "--levels",
        "max_error_px" => "--max-error-px",
        "speed_mps" => "--speed",
        other => other,
    }
}
