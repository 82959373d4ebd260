//! What exact culling costs, and what fast culling keeps without need: methods against exact
//! arithmetic, over all boxes of a city and over those at the borders of what is seen.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::json;
use wide::f32x8;

use super::city::{self, GONG_OBJECTS, SEED};
use super::exact::{Answer, Camera, Oracle};
use super::plot::{self, Labels, Series};
use super::report::{Plot, Table, circumstances, thousands};
use super::timing::{median, median_us, seconds};
use super::{Options, Progress, Report, ReportError, stability};
use crate::geom::{
    ALL_LANES, Aabb, DVec3, Eight, Filter, Frustum, Plane, Relation, SeparatingAxes, View,
};
use crate::index::{self, LodTree, Promotion};
use crate::scene::{CityParams, generate};

const PLACES: u32 = 4;
const SAMPLES: usize = 5;
/// Of cities with more objects, every n-th is looked at.
const MOST_BOXES: usize = 50_000;
/// Where a national grid may have a city.
const GRID_OFFSET: DVec3 = DVec3::new(460_000.25, 5_400_000.5, 120.125);

/// One method over one set of boxes.
struct Row {
    city: String,
    boxes: &'static str,
    method: &'static str,
    tested: usize,
    meeting: usize,
    kept: usize,
    false_negatives: usize,
    ns_per_box: f64,
}

impl Row {
    /// Share of what is kept that does not meet the frustum, %.
    fn false_positive_pct(&self) -> f64 {
        let needless = self.kept + self.false_negatives - self.meeting;
        100.0 * needless as f64 / (self.kept as f64).max(1.0)
    }
}

pub(super) fn run(options: &Options, progress: &Progress) -> Result<Report, ReportError> {
    let mut rows = Vec::new();
    let mut look = |name: String, tree: &LodTree| -> Result<(), ReportError> {
        progress(&name);
        measure(&name, tree, &mut rows)
    };
    for path in &options.cities {
        look(city::name(path), &city::from_file(path)?)?;
    }
    let mut scene = generate(&CityParams {
        objects: GONG_OBJECTS,
        seed: SEED,
    });
    look(
        "generated".into(),
        &index::build(&scene, Promotion::default())?,
    )?;
    for object in &mut scene.objects {
        let corners = [object.bounds.min(), object.bounds.max()];
        object.bounds = Aabb::around(corners.map(|corner| corner + GRID_OFFSET));
    }
    look(
        "generated, in a national grid".into(),
        &index::build(&scene, Promotion::default())?,
    )?;
    report(&rows)
}

/// A set of boxes in every form that a method reads.
struct Boxes {
    exact: Vec<Aabb>,
    blocks: Vec<Eight>,
    /// World coordinates rounded to the nearest f32, as a renderer has them.
    nearest: Vec<[f32; 6]>,
    spheres: Vec<(DVec3, f64)>,
}

impl Boxes {
    fn new(tree: &LodTree, objects: &[u32]) -> Self {
        let exact: Vec<Aabb> = objects.iter().filter_map(|&o| tree.bounds_of(o)).collect();
        let relative: Vec<[f32; 6]> = objects
            .iter()
            .filter_map(|&o| tree.relative_box(o))
            .collect();
        let block = |chunk: &[[f32; 6]]| -> Eight {
            std::array::from_fn(|k| {
                let lane = |i| chunk.get(i).map_or(0.0, |b: &[f32; 6]| b[k]);
                f32x8::new(std::array::from_fn(lane))
            })
        };
        Self {
            blocks: relative.chunks(8).map(block).collect(),
            nearest: exact
                .iter()
                .map(|b| b.to_array().map(|c| c as f32))
                .collect(),
            spheres: exact.iter().map(|b| (b.center(), b.radius())).collect(),
            exact,
        }
    }
}

/// All objects; of objects, of nodes and of random boxes those that the planes leave crossing.
fn measure(name: &str, tree: &LodTree, rows: &mut Vec<Row>) -> Result<(), ReportError> {
    let cameras = city::level_cameras(tree, PLACES);
    let nodes = tree.arrays().node_boxes.iter();
    let nodes: Vec<Aabb> = nodes.filter_map(|b| Aabb::from_array(*b).ok()).collect();
    let nodes = stability::city(&nodes)?;
    let random = stability::city(&random_boxes(&tree.bounds()))?;
    for (boxes, tree, crossing) in [
        ("all objects", tree, false),
        ("objects at borders", tree, true),
        ("nodes at borders", &nodes, true),
        ("random at borders", &random, true),
    ] {
        let step = (tree.object_count() as usize).div_ceil(MOST_BOXES).max(1);
        let mut per_view: Vec<Vec<Outcome>> = Vec::new();
        for camera in &cameras {
            let view = camera.view()?;
            let mut objects: Vec<u32> = (0..tree.object_count()).step_by(step).collect();
            objects.retain(|&o| {
                let relation = |b| view.frustum().relation(&b);
                !crossing || tree.bounds_of(o).map(relation) == Some(Relation::Crossing)
            });
            if !objects.is_empty() {
                per_view.push(outcomes(camera, &view, tree, &Boxes::new(tree, &objects)));
            }
        }
        let methods = per_view.first().map_or(0, Vec::len);
        for method in 0..methods {
            let of = || per_view.iter().map(|outcomes| &outcomes[method]);
            rows.push(Row {
                city: name.to_owned(),
                boxes,
                method: per_view[0][method].method,
                tested: of().map(|o| o.tested).sum(),
                meeting: of().map(|o| o.meeting).sum(),
                kept: of().map(|o| o.kept).sum(),
                false_negatives: of().map(|o| o.false_negatives).sum(),
                ns_per_box: median(of().map(|o| o.ns_per_box).collect()),
            });
        }
    }
    Ok(())
}

/// Boxes of a metre to the whole city, anywhere in it.
fn random_boxes(bounds: &Aabb) -> Vec<Aabb> {
    const COUNT: usize = 20_000;
    let mut rng = Pcg64Mcg::seed_from_u64(SEED);
    let mut number = move || rng.random::<f64>();
    let any = |_| {
        let at = bounds.min() + bounds.size() * DVec3::new(number(), number(), number());
        let size = bounds.size().max_element().max(1.0).powf(number());
        let size = DVec3::new(number(), number(), number() * 0.3) * size;
        Aabb::around([at - size * 0.5, at + size * 0.5])
    };
    (0..COUNT).map(any).collect()
}

struct Outcome {
    method: &'static str,
    tested: usize,
    meeting: usize,
    kept: usize,
    false_negatives: usize,
    ns_per_box: f64,
}

/// Every method over the boxes in one view, the oracle first.
fn outcomes(camera: &Camera, view: &View, tree: &LodTree, boxes: &Boxes) -> Vec<Outcome> {
    let frustum = view.frustum();
    let filter = Filter::new(frustum, tree.origin(), &tree.bounds());
    let axes = SeparatingAxes::new(frustum);
    let oracle = Oracle::new(camera);
    let tested = boxes.exact.len();
    let ask = || -> Vec<bool> {
        let meets = boxes.exact.iter().map(|b| oracle.meets(b) != Answer::No);
        meets.collect()
    };
    let (oracle_s, truth) = seconds(ask);
    let meeting = truth.iter().filter(|meets| **meets).count();
    let outcome = |method, kept: &[bool], ns_per_box| Outcome {
        method,
        tested,
        meeting,
        kept: kept.iter().filter(|kept| **kept).count(),
        false_negatives: kept.iter().zip(&truth).filter(|(k, m)| !**k && **m).count(),
        ns_per_box,
    };
    let mut found = vec![outcome(
        "exact arithmetic",
        &truth,
        oracle_s * 1e9 / tested as f64,
    )];
    let mut kept = vec![false; tested];
    let mut method = |name, cull: &mut dyn FnMut(&mut [bool])| {
        let us = median_us(SAMPLES, || cull(&mut kept));
        found.push(outcome(name, &kept, us * 1e3 / tested as f64));
    };
    method("f32 planes, eight lanes, f64 where open", &mut |kept| {
        eight_lanes(&filter, frustum, boxes, kept);
    });
    method("f64 planes", &mut |kept| {
        for (kept, b) in kept.iter_mut().zip(&boxes.exact) {
            *kept = !frustum.is_outside(b);
        }
    });
    method("f64 planes and separating axes", &mut |kept| {
        for (kept, b) in kept.iter_mut().zip(&boxes.exact) {
            *kept = !frustum.is_outside(b) && !axes.separate(b);
        }
    });
    method("eight lanes and separating axes", &mut |kept| {
        let exact = boxes.exact.chunks(8).zip(&boxes.blocks);
        for (kept, (exact, block)) in kept.chunks_mut(8).zip(exact) {
            let relations = filter.relations(block, filter.all_planes());
            for (lane, (kept, b)) in kept.iter_mut().zip(exact).enumerate() {
                *kept = (relations.inside >> lane) & 1 == 1
                    || (relations.outside >> lane) & 1 == 0
                        && !axes.separate(b)
                        && !frustum.is_outside(b);
            }
        }
    });
    let planes: Vec<[f32; 4]> = frustum.planes().iter().map(|p| world(frustum, p)).collect();
    method("f32 planes without slack", &mut |kept| {
        for (kept, b) in kept.iter_mut().zip(&boxes.nearest) {
            *kept = !planes.iter().any(|plane| beyond(plane, b));
        }
    });
    let unit: Vec<(DVec3, f64)> = frustum.planes().iter().map(unit).collect();
    method("bounding spheres", &mut |kept| {
        for (kept, (middle, radius)) in kept.iter_mut().zip(&boxes.spheres) {
            let from_eye = *middle - frustum.eye();
            *kept = !unit.iter().any(|(n, d)| n.dot(from_eye) + d < -radius);
        }
    });
    found
}

/// As retrieval does it.
fn eight_lanes(filter: &Filter, frustum: &Frustum, boxes: &Boxes, kept: &mut [bool]) {
    let exact = boxes.exact.chunks(8).zip(&boxes.blocks);
    for (kept, (exact, block)) in kept.chunks_mut(8).zip(exact) {
        let (outside, touching) = filter.outside_or_touching(block, filter.all_planes());
        let open = ALL_LANES & !(outside | touching);
        for (lane, (kept, b)) in kept.iter_mut().zip(exact).enumerate() {
            *kept =
                (touching >> lane) & 1 == 1 || (open >> lane) & 1 == 1 && !frustum.is_outside(b);
        }
    }
}

/// A plane in world coordinates and f32.
fn world(frustum: &Frustum, plane: &Plane) -> [f32; 4] {
    let n = plane.normal;
    [n.x, n.y, n.z, plane.offset - n.dot(frustum.eye())].map(|c| c as f32)
}

fn beyond([a, b, c, d]: &[f32; 4], corners: &[f32; 6]) -> bool {
    let pick = |n: f32, axis: usize| n * corners[if n >= 0.0 { axis + 3 } else { axis }];
    pick(*a, 0) + pick(*b, 1) + pick(*c, 2) + d < 0.0
}

fn unit(plane: &Plane) -> (DVec3, f64) {
    let length = plane.normal.length();
    (plane.normal / length, plane.offset / length)
}

fn report(rows: &[Row]) -> Result<Report, ReportError> {
    let text = format!(
        "Methods of culling against exact arithmetic in {} level views.\nFalse positives: share of \
         what is kept that does not meet the frustum. False negatives: boxes that meet it and are \
         lost.\nTimes are medians over the views.",
        PLACES * 4
    );
    let cells = rows.iter().map(|row| {
        vec![
            row.city.clone(),
            row.boxes.to_owned(),
            row.method.to_owned(),
            thousands(row.tested as u64),
            thousands(row.kept as u64),
            format!("{:.3}", row.false_positive_pct()),
            row.false_negatives.to_string(),
            format!("{:.1}", row.ns_per_box),
        ]
    });
    let json_rows = rows.iter().map(|row| {
        json!({
            "city": row.city, "boxes": row.boxes, "method": row.method, "tested": row.tested,
            "meeting": row.meeting, "kept": row.kept,
            "false_positive_pct": row.false_positive_pct(),
            "false_negatives": row.false_negatives, "ns_per_box": row.ns_per_box,
        })
    });
    let at_borders = rows.iter().filter(|row| row.boxes == "random at borders");
    let mut series: Vec<Series> = Vec::new();
    for row in at_borders.filter(|row| row.meeting > 0 && row.kept > 0) {
        let point = (row.ns_per_box, row.kept as f64 / row.meeting as f64);
        match series.iter_mut().find(|s| s.name == row.method) {
            Some(series) => series.points.push(point),
            None => series.push(Series {
                name: row.method.to_owned(),
                points: vec![point],
                reference: false,
            }),
        }
    }
    let labels = Labels {
        title: "Random boxes at borders: what a method keeps against what it costs",
        x: "ns a box",
        y: "kept for each that meets",
    };
    Ok(Report {
        name: "culling",
        text,
        tables: vec![Table {
            columns: vec![
                "city",
                "boxes",
                "method",
                "tested",
                "kept",
                "false_positive_pct",
                "false_negatives",
                "ns_per_box",
            ],
            rows: cells.collect(),
            ..Table::default()
        }],
        json: json!({
                "rows": json_rows.collect::<Vec<_>>(),
                "circumstances": circumstances(&json!({ "views": PLACES * 4, "most_boxes": MOST_BOXES })),
        }),
        plots: vec![Plot {
            svg: plot::log_log(&labels, &series)?,
            ..Plot::default()
        }],
        ..Report::default()
    })
}
