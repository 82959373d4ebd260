//! What is drawn with and without LOD in a level view, a far and a near overlook (Gong, section 3,
//! figures 1 to 3).
//!
//! Gong finds: level, the two look nearly the same while the counts differ much; from far away they
//! differ visibly, the pattern of the city is kept; near, all is within the finest level's range
//! and the two are the same.

use serde_json::json;

use super::city::{self, GONG_OBJECTS};
use super::report::{ReportPicture, Table, circumstances, thousands};
use super::{Options, Progress, Report, ReportError};
use crate::geom::{Aabb, DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;
use crate::lod::{Beyond, RangeLod, Selection, retrieve};
use crate::raster::{Solid, paint};

const FAR_DIST_M: f64 = 500.0;
const DIST_FACTOR: f64 = 2.5;
const SIZE: [u32; 2] = [1280, 720];

#[derive(Debug, Clone, Copy)]
enum Tint {
    Class,
    Level,
}

pub(super) fn run(options: &Options, progress: &Progress) -> Result<Report, ReportError> {
    let mut report = Report {
        name: "views",
        text: format!(
            "Objects drawn with LOD (far_dist {FAR_DIST_M} m, dist_factor {DIST_FACTOR}, all \
             levels) and without, in a level view, a far and a near overlook."
        ),
        ..Report::default()
    };
    let mut table = Table {
        columns: vec!["city", "view", "lod", "count", "share_pct"],
        ..Table::default()
    };
    let mut rows = Vec::new();
    progress(&format!(
        "generated city of {} objects",
        thousands(GONG_OBJECTS.into())
    ));
    let generated = city::generated(GONG_OBJECTS)?;
    look(
        &mut report,
        &mut table,
        &mut rows,
        "generated",
        &generated,
        progress,
    )?;
    for path in &options.cities {
        progress(&path.display().to_string());
        let tree = city::from_file(path)?;
        look(
            &mut report,
            &mut table,
            &mut rows,
            &city::name(path),
            &tree,
            progress,
        )?;
    }
    let parameters = json!({
        "far_dist_m": FAR_DIST_M, "dist_factor": DIST_FACTOR, "viewport": SIZE,
    });
    report.tables.push(table);
    report.json = json!({ "rows": rows, "circumstances": circumstances(&parameters) });
    Ok(report)
}

/// The three views of a city, in numbers and pictures.
fn look(
    report: &mut Report,
    table: &mut Table,
    rows: &mut Vec<serde_json::Value>,
    name: &str,
    tree: &LodTree,
    progress: &Progress,
) -> Result<(), ReportError> {
    let levels = tree.level_count().max(1);
    let lod = RangeLod::new(FAR_DIST_M, DIST_FACTOR, levels, Beyond::Show).unwrap_or_default();
    let mut selection = Selection::default();
    for (kind, view) in [
        ("level", level(tree)?),
        ("far", far(tree)?),
        ("near", near(tree)?),
    ] {
        progress(&format!("{name}: {kind} view"));
        retrieve(tree, &view, &RangeLod::full_detail(), &mut selection);
        let all = selection.count();
        for (with_lod, knobs) in [(false, RangeLod::full_detail()), (true, lod)] {
            retrieve(tree, &view, &knobs, &mut selection);
            let count = selection.count();
            let with = if with_lod { "with" } else { "without" };
            table.rows.push(vec![
                name.to_owned(),
                kind.to_owned(),
                with.to_owned(),
                count.to_string(),
                format!("{:.1}", 100.0 * f64::from(count) / f64::from(all.max(1))),
            ]);
            rows.push(json!({ "city": name, "view": kind, "lod": with_lod, "count": count }));
            let objects = thousands(count.into());
            report.pictures.push(picture(
                tree,
                &view,
                &selection,
                Tint::Class,
                format!("views-{name}-{kind}-{with}-lod.png"),
                format!("{name}, {kind} view {with} LOD: {objects} objects"),
            )?);
        }
        report.pictures.push(picture(
            tree,
            &view,
            &selection,
            Tint::Level,
            format!("views-{name}-{kind}-levels.png"),
            format!("{name}, {kind} view with LOD, coloured by level: the lightest is the finest"),
        )?);
    }
    Ok(())
}

fn picture(
    tree: &LodTree,
    view: &View,
    selection: &Selection,
    tint: Tint,
    file: String,
    caption: String,
) -> Result<ReportPicture, ReportError> {
    let objects = selection.objects().filter_map(|number| tree.object(number));
    let solids: Vec<Solid> = objects
        .map(|object| match tint {
            Tint::Class => Solid::by_class(object.bounds, object.class, &object.id),
            Tint::Level => Solid::by_level(object.bounds, object.class, object.level),
        })
        .collect();
    let painted = paint(view, SIZE, &solids, tree.bounds().min().z);
    let mut png = Vec::new();
    match painted.write_png(&mut png) {
        Ok(()) => Ok(ReportPicture { file, caption, png }),
        Err(source) => Err(ReportError::Write {
            path: file.into(),
            source,
        }),
    }
}

/// "The viewpoint close to the ground, the line of sight level": a little above the roofs.
fn level(tree: &LodTree) -> Result<View, ReportError> {
    let mut views = city::level_views(tree, 1)?;
    views.truncate(1);
    match views.pop() {
        Some(view) => Ok(view),
        None => camera(DVec3::ZERO, DVec3::Y),
    }
}

/// The city's middle, from more than twice as far away as the finest level reaches.
fn far(tree: &LodTree) -> Result<View, ReportError> {
    let middle = city::densest(tree).with_z(tree.bounds().min().z);
    camera(
        middle + DVec3::new(0.35, -1.0, 0.7) * (2.2 * FAR_DIST_M),
        middle,
    )
}

/// A place among low houses, from above them, so near that nothing seen is beyond `far_dist`.
fn near(tree: &LodTree) -> Result<View, ReportError> {
    const ABOVE_M: f64 = 90.0;
    const AROUND_M: f64 = 160.0;
    const PLACES: u32 = 64;
    let middle = city::densest(tree);
    let spread = tree.bounds().size().truncate().min_element() * 0.2;
    let top = |place: DVec3| {
        let reach = DVec3::new(AROUND_M, AROUND_M, f64::INFINITY);
        let objects = tree.arrays().object_boxes.iter();
        let boxes = objects.filter_map(|b| Aabb::from_array(*b).ok());
        let around = boxes.filter(|b| (b.min() - place).max(place - b.max()).cmple(reach).all());
        around.fold(f64::NEG_INFINITY, |top, b| top.max(b.max().z))
    };
    let places = city::spiral(middle, spread, PLACES);
    let found = places.map(|place| (top(place), place));
    let lowest = found
        .filter(|place| place.0.is_finite())
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let (top, place) = lowest.unwrap_or((tree.bounds().max().z, middle));
    let target = place.with_z(tree.bounds().min().z);
    camera(
        place.with_z(top + ABOVE_M) + DVec3::new(0.0, -AROUND_M * 0.4, 0.0),
        target,
    )
}

fn camera(eye: DVec3, target: DVec3) -> Result<View, ReportError> {
    let depth = DepthRange::default();
    let up = DVec3::Z;
    let orientation = Orientation::LookAt { target, up };
    let projection = Projection::Perspective { fov_y_deg: 50.0 };
    Ok(View::new(eye, orientation, projection, depth, SIZE)?)
}
