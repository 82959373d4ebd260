//! What a retrieval costs against the number of objects, beside testing every box and beside
//! rstar's own selection.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree, RTreeObject, SelectionFunction};
use serde_json::json;

use super::plot::{self, Labels, Series};
use super::report::{Plot, Table, circumstances, thousands};
use super::timing::{median, median_us, seconds};
use super::{Options, Progress, Report, ReportError, city};
use crate::geom::View;
use crate::index::{self, FileError, LodTree, Promotion};
use crate::lod::{Beyond, RangeLod, Selection, retrieve};
use crate::scene::{CityParams, Scene, generate};

const SIZES: [u32; 4] = [10_000, 100_000, 1_000_000, 10_000_000];
const LARGEST: u32 = 10_000_000;
const PLACES: u32 = 4;
/// One of Gong's.
const FAR_DIST_M: f64 = 1000.0;
/// Wide enough that large cities show tens of thousands of objects.
const DENSE_FAR_DIST_M: f64 = 4000.0;
const DIST_FACTOR: f64 = 2.5;
const SAMPLES: usize = 7;
const BUILDS: usize = 5;
/// Baselines take up to a fifth of a second a call.
const BASELINE_SAMPLES: usize = 3;

#[derive(Debug, Clone, Copy)]
struct Row {
    objects: u32,
    build_s: f64,
    rstar_build_s: f64,
    open_ms: f64,
    bytes: usize,
    visible: f64,
    retrieve_us: f64,
    ns_per_visible: f64,
    copy_us: f64,
    dense_visible: f64,
    dense_us: f64,
    dense_ns_per_visible: f64,
    linear_us: f64,
    full_visible: f64,
    full_us: f64,
    rstar_us: f64,
    /// Median over the views of rstar's time by ours for the same answer.
    rstar_ratio: f64,
}

pub(super) fn run(options: &Options, progress: &Progress) -> Result<Report, ReportError> {
    let largest = options.largest.unwrap_or(LARGEST);
    let mut rows = Vec::new();
    let mut sizes: Vec<u32> = SIZES.into_iter().filter(|&n| n <= largest).collect();
    if let Some(asked) = options.largest
        && !sizes.contains(&asked)
    {
        sizes.push(asked);
    }
    for objects in sizes {
        progress(&format!(
            "{} objects: generating",
            thousands(objects.into())
        ));
        let seed = city::SEED;
        let scene = generate(&CityParams { objects, seed });
        rows.push(measure(&scene, progress)?);
    }
    report(&rows)
}

fn measure(scene: &Scene, progress: &Progress) -> Result<Row, ReportError> {
    let objects = scene.objects.len() as u32;
    let at = |what: &str| progress(&format!("{} objects: {what}", thousands(objects.into())));
    at("building");
    let (mut build_s, mut rstar_build_s) = (Vec::new(), Vec::new());
    let (tree, rstar) = loop {
        let (ours, tree) = seconds(|| index::build(scene, Promotion::default()));
        let tree = tree?;
        let (theirs, rstar) = seconds(|| rstar_tree(&tree));
        build_s.push(ours);
        rstar_build_s.push(theirs);
        // In turn, and neither beside the last ones: where memory is new to a process, whoever
        // builds first pays for it.
        if build_s.len() == BUILDS {
            break (tree, rstar);
        }
    };
    let (build_s, rstar_build_s) = (median(build_s), median(rstar_build_s));
    let (open_ms, bytes) = open(&tree)?;

    let lod = |far_dist| {
        RangeLod::new(far_dist, DIST_FACTOR, tree.level_count(), Beyond::Show).unwrap_or_default()
    };
    let (usual, dense) = (lod(FAR_DIST_M), lod(DENSE_FAR_DIST_M));
    let views = city::level_views(&tree, PLACES)?;
    let mut selection = Selection::default();
    let mut per_view: Vec<[f64; 12]> = Vec::new();
    for (i, view) in views.iter().enumerate() {
        at(&format!("view {} of {}", i + 1, views.len()));
        let retrieve_us = median_us(SAMPLES, || retrieve(&tree, view, &usual, &mut selection));
        let visible = f64::from(selection.count());
        let mut ids = Vec::new();
        let copy_us = median_us(SAMPLES, || copy_ids(&tree, &selection, &mut ids));
        let dense_us = median_us(SAMPLES, || retrieve(&tree, view, &dense, &mut selection));
        let dense_visible = f64::from(selection.count());
        let full = RangeLod::full_detail();
        let full_us = median_us(SAMPLES, || retrieve(&tree, view, &full, &mut selection));
        let full_visible = f64::from(selection.count());
        let linear_us = median_us(BASELINE_SAMPLES, || test_every_box(&tree, view));
        let rstar_us = median_us(BASELINE_SAMPLES, || select_with_rstar(&rstar, view));
        per_view.push([
            visible,
            retrieve_us,
            retrieve_us * 1e3 / visible,
            copy_us,
            dense_visible,
            dense_us,
            dense_us * 1e3 / dense_visible,
            linear_us,
            full_visible,
            full_us,
            rstar_us,
            rstar_us / full_us,
        ]);
    }
    let middle = |column: usize| median(per_view.iter().map(|row| row[column]).collect());
    Ok(Row {
        objects,
        build_s,
        rstar_build_s,
        open_ms,
        bytes,
        visible: middle(0),
        retrieve_us: middle(1),
        ns_per_visible: middle(2),
        copy_us: middle(3),
        dense_visible: middle(4),
        dense_us: middle(5),
        dense_ns_per_visible: middle(6),
        linear_us: middle(7),
        full_visible: middle(8),
        full_us: middle(9),
        rstar_us: middle(10),
        rstar_ratio: middle(11),
    })
}

/// Median time to open the tree from a file, and the file's size.
fn open(tree: &LodTree) -> Result<(f64, usize), ReportError> {
    let folder = tempfile::tempdir().map_err(|source| ReportError::Write {
        path: std::env::temp_dir(),
        source,
    })?;
    let path = folder.path().join("scaling.citylod");
    tree.save(&path)?;
    let runs: Result<Vec<f64>, FileError> = (0..SAMPLES)
        .map(|_| {
            let (s, opened) = seconds(|| LodTree::open(&path));
            opened.map(|_| s * 1e3)
        })
        .collect();
    Ok((median(runs?), tree.byte_len()))
}

fn copy_ids(tree: &LodTree, selection: &Selection, ids: &mut Vec<u8>) -> usize {
    ids.clear();
    for range in selection.ranges() {
        ids.extend_from_slice(tree.ids_json(range.clone()));
    }
    ids.len()
}

/// The plainest test there is, for the baselines: no slack, out at the first plane.
fn is_outside(view: &View, min: [f64; 3], max: [f64; 3]) -> bool {
    let eye = view.eye().to_array();
    view.frustum().planes().iter().any(|plane| {
        let normal = plane.normal.to_array();
        let farthest = |axis: usize| {
            let corner = if normal[axis] >= 0.0 { max } else { min };
            normal[axis] * (corner[axis] - eye[axis])
        };
        farthest(0) + farthest(1) + farthest(2) + plane.offset < 0.0
    })
}

/// The baseline without a tree.
fn test_every_box(tree: &LodTree, view: &View) -> Vec<u32> {
    (0..)
        .zip(tree.arrays().object_boxes)
        .filter(|(_, [x0, y0, z0, x1, y1, z1])| !is_outside(view, [*x0, *y0, *z0], [*x1, *y1, *z1]))
        .map(|(object, _)| object)
        .collect()
}

type RstarObject = GeomWithData<Rectangle<[f64; 3]>, u32>;

/// rstar as it comes: its default parameters, f64 boxes.
fn rstar_tree(tree: &LodTree) -> RTree<RstarObject> {
    let boxes = tree.arrays().object_boxes.iter();
    let objects = boxes.zip(0..).map(|(&[x0, y0, z0, x1, y1, z1], object)| {
        let rectangle = Rectangle::from_corners([x0, y0, z0], [x1, y1, z1]);
        GeomWithData::new(rectangle, object)
    });
    RTree::bulk_load(objects.collect())
}

struct InFrustum<'a>(&'a View);

impl InFrustum<'_> {
    fn sees(&self, envelope: &AABB<[f64; 3]>) -> bool {
        !is_outside(self.0, envelope.lower(), envelope.upper())
    }
}

impl SelectionFunction<RstarObject> for InFrustum<'_> {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; 3]>) -> bool {
        self.sees(envelope)
    }

    fn should_unpack_leaf(&self, leaf: &RstarObject) -> bool {
        self.sees(&leaf.envelope())
    }
}

fn select_with_rstar(rstar: &RTree<RstarObject>, view: &View) -> Vec<u32> {
    let mut found = Vec::new();
    for object in rstar.locate_with_selection_function(InFrustum(view)) {
        found.push(object.data);
    }
    found
}

impl Row {
    fn cells(&self) -> Vec<String> {
        vec![
            self.objects.to_string(),
            format!("{:.2}", self.build_s),
            format!("{:.2}", self.rstar_build_s),
            format!("{:.3}", self.open_ms),
            format!("{:.0}", self.visible),
            format!("{:.1}", self.retrieve_us),
            format!("{:.2}", self.ns_per_visible),
            format!("{:.1}", self.copy_us),
            format!("{:.0}", self.dense_visible),
            format!("{:.1}", self.dense_us),
            format!("{:.2}", self.dense_ns_per_visible),
            format!("{:.0}", self.linear_us),
            format!("{:.0}", self.linear_us / self.retrieve_us),
            format!("{:.0}", self.full_visible),
            format!("{:.1}", self.full_us),
            format!("{:.0}", self.rstar_us),
            format!("{:.0}", self.rstar_ratio),
        ]
    }

    fn record(&self) -> serde_json::Value {
        json!({
            "objects": self.objects,
            "build_s": self.build_s,
            "rstar_build_s": self.rstar_build_s,
            "open_ms": self.open_ms,
            "bytes": self.bytes,
            "visible": self.visible,
            "retrieve_us": self.retrieve_us,
            "ns_per_visible": self.ns_per_visible,
            "copy_us": self.copy_us,
            "dense_visible": self.dense_visible,
            "dense_us": self.dense_us,
            "dense_ns_per_visible": self.dense_ns_per_visible,
            "linear_us": self.linear_us,
            "full_visible": self.full_visible,
            "full_us": self.full_us,
            "rstar_us": self.rstar_us,
            "rstar_over_full": self.rstar_ratio,
        })
    }
}

const COLUMNS: [&str; 17] = [
    "objects",
    "build_s",
    "rstar_build_s",
    "open_ms",
    "visible",
    "retrieve_us",
    "ns_per_visible",
    "copy_us",
    "dense_visible",
    "dense_us",
    "dense_ns_per_visible",
    "linear_us",
    "linear_ratio",
    "full_visible",
    "full_us",
    "rstar_us",
    "rstar_ratio",
];

fn report(rows: &[Row]) -> Result<Report, ReportError> {
    let series = |name: &str, reference: bool, value: fn(&Row) -> f64| Series {
        name: name.into(),
        points: rows
            .iter()
            .map(|r| (f64::from(r.objects), value(r)))
            .collect(),
        reference,
    };
    let labels = Labels {
        title: "Time of one retrieval",
        x: "objects in the city",
        y: "microseconds",
    };
    let svg = plot::log_log(
        &labels,
        &[
            series("retrieve with LOD", false, |r| r.retrieve_us),
            series("retrieve all in the frustum", false, |r| r.full_us),
            series("the same with rstar", true, |r| r.rstar_us),
            series("test every box", true, |r| r.linear_us),
        ],
    )?;
    let parameters = json!({
        "far_dist_m": FAR_DIST_M,
        "dense_far_dist_m": DENSE_FAR_DIST_M,
        "dist_factor": DIST_FACTOR,
        "views": PLACES * 4,
        "samples": SAMPLES,
    });
    let views = PLACES * 4;
    Ok(Report {
        name: "scaling",
        text: format!(
            "Medians over {views} level views, dist_factor {DIST_FACTOR}, all levels.\n\
             retrieve: far_dist {FAR_DIST_M} m; dense: far_dist {DENSE_FAR_DIST_M} m.\n\
             linear: test every box. full: everything in the frustum, as rstar selects it.\n\
             build and rstar_build: from objects in memory to a tree."
        ),
        tables: vec![Table {
            columns: COLUMNS.to_vec(),
            rows: rows.iter().map(Row::cells).collect(),
            ..Table::default()
        }],
        plots: vec![Plot {
            svg,
            ..Plot::default()
        }],
        json: json!({
            "rows": rows.iter().map(Row::record).collect::<Vec<_>>(),
            "circumstances": circumstances(&parameters),
        }),
        ..Report::default()
    })
}
