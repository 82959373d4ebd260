//! What a camera selects in a city, as `query` and `render` need it.

use std::time::Instant;

use anyhow::{Result, bail};

use super::args::{BeyondArg, CullingArg, EffectArg, SelectArgs, misuse};
use super::{ground, text};
use crate::effects::terrain::Land;
use crate::frame::{Active, Culling, Frame, Ran};
use crate::geom::{DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;
use crate::lod::{Beyond, BudgetLod, ErrorLod, Lod, LodError, RangeLod};
use crate::scene::Effects;

/// A city, a camera and what it draws.
pub(super) struct Selected {
    pub tree: LodTree,
    /// The ground, where the city declares terrain and it is not switched off.
    pub land: Option<Land>,
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
    if let Some(speed) = args.speed {
        if !(speed >= 0.0 && speed.is_finite()) {
            let reason = format!("must be 0 or more and finite, is {speed}");
            return Err(wrong("speed_mps", &reason).into());
        }
        if args.without.contains(&EffectArg::Motion) {
            let reason = "is of motion, which --without switches off";
            return Err(wrong("speed_mps", reason).into());
        }
    }
    let tree = LodTree::open_verified(&args.file)?;
    let active = active(args, tree.effects())?;
    let land = match active.terrain {
        Some(_) => ground::land(&args.file, &tree)?,
        None => None,
    };
    let mut frame = Frame::default();
    let start = Instant::now();
    for _ in 0..times {
        match &land {
            Some(land) => {
                frame.work_out_on(land, &tree, &view, &lod, &active, || start.elapsed());
            }
            None => frame.work_out(&tree, &view, &lod, &active, || start.elapsed()),
        }
    }
    Ok(Selected {
        tree,
        land,
        view,
        frame,
    })
}

/// What the city declares, less what is switched off. As over HTTP, to switch off what is not
/// declared changes nothing, and to ask for it is an error.
fn active(args: &SelectArgs, declared: &Effects) -> Result<Active> {
    if args.speed.is_some() {
        require(declared.motion.is_some(), args, "motion", "--speed")?;
    }
    let mut active = Active::all(declared, args.speed.unwrap_or_default());
    active.culling = match args.culling {
        CullingArg::Fast => Culling::Fast,
        CullingArg::Exact => Culling::Exact,
    };
    for effect in &args.without {
        match effect {
            EffectArg::Motion => active.motion = None,
            EffectArg::Haze => active.haze = None,
            EffectArg::Occlusion => active.occlusion = None,
            EffectArg::Terrain => active.terrain = None,
        }
    }
    Ok(active)
}

/// Refuses what is of an effect that the city does not declare.
pub(super) fn require(declared: bool, args: &SelectArgs, effect: &str, flag: &str) -> Result<()> {
    if declared {
        return Ok(());
    }
    let city = args.file.display();
    let way_out = if effect == "terrain" {
        format!("lay its ground with citylod import ELEVATION --into {city}")
    } else {
        "declare it with --effects when the city is imported or generated".into()
    };
    bail!("{city}: does not declare {effect}, which {flag} is of; {way_out}")
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
    let depth = DepthRange::default();
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
