//! How many objects are drawn for Gong's six far distances (section 3, figure 4).
//!
//! The theory says that the number grows with `far_dist`², by 2.25 for each step of 1.5. A node's
//! distance is that of its nearest point, so what is drawn reaches beyond `far_dist` by the size
//! of a node, and the number grows like (D + s)² with s the node size: by less than 2.25 until D
//! is much larger than s. A bounded city saturates. The model is fitted and s reported.

use std::fmt::Write as _;

use serde_json::json;

use super::city::{self, GONG_OBJECTS};
use super::plot::{self, Labels, Series};
use super::report::{Plot, Table, circumstances, thousands};
use super::timing::median;
use super::{Options, Progress, Report, ReportError, fit};
use crate::index::LodTree;
use crate::lod::{Beyond, RangeLod, Selection, retrieve};

/// Gong, section 3.
const FAR_DISTS_M: [f64; 6] = [200.0, 300.0, 450.0, 675.0, 1000.0, 1500.0];
const DIST_FACTOR: f64 = 3.0;
/// 1.5², which 675 → 1000 falls short of a little.
const THEORY: f64 = 2.25;
const PLACES: u32 = 8;
const LARGEST: u32 = 10_000_000;

struct City {
    name: String,
    objects: u32,
    /// (`far_dist`, median count over the views).
    counts: Vec<(f64, f64)>,
}

pub(super) fn run(options: &Options, progress: &Progress) -> Result<Report, ReportError> {
    let largest = options.largest.unwrap_or(LARGEST);
    let mut cities = Vec::new();
    for objects in [GONG_OBJECTS, largest] {
        progress(&format!(
            "generated city of {} objects",
            thousands(objects.into())
        ));
        cities.push(measure("generated".into(), &city::generated(objects)?)?);
    }
    for path in &options.cities {
        progress(&path.display().to_string());
        cities.push(measure(city::name(path), &city::from_file(path)?)?);
    }
    report(&cities)
}

fn measure(name: String, tree: &LodTree) -> Result<City, ReportError> {
    let views = city::level_views(tree, PLACES)?;
    let mut selection = Selection::default();
    let mut counts = Vec::new();
    for far_dist in FAR_DISTS_M {
        let lod = RangeLod::new(
            far_dist,
            DIST_FACTOR,
            tree.level_count().max(1),
            Beyond::Show,
        )
        .unwrap_or_default();
        let per_view = views.iter().map(|view| {
            retrieve(tree, view, &lod, &mut selection);
            f64::from(selection.count())
        });
        counts.push((far_dist, median(per_view.collect())));
    }
    Ok(City {
        name,
        objects: tree.object_count(),
        counts,
    })
}

impl City {
    fn ratios(&self) -> Vec<f64> {
        self.counts.windows(2).map(|p| p[1].1 / p[0].1).collect()
    }

    fn mean_ratio(&self) -> f64 {
        let ratios = self.ratios();
        ratios.iter().sum::<f64>() / ratios.len() as f64
    }
}

/// A number for people; a city smaller than the first distance fits no model.
fn finite(number: f64, digits: usize) -> String {
    if number.is_finite() {
        format!("{number:.digits$}")
    } else {
        "-".into()
    }
}

fn report(cities: &[City]) -> Result<Report, ReportError> {
    let mut rows = Vec::new();
    let mut scenes = Vec::new();
    let mut series = Vec::new();
    let mut text = format!(
        "Objects drawn for six far distances, dist_factor {DIST_FACTOR}, all levels, median of \
         {} level views.\nTheory: x{THEORY} a step. Model: count = c (far_dist + s)^2.",
        PLACES * 4
    );
    for city in cities {
        let model = fit::disc_model(&city.counts);
        let exponent = fit::exponent(&city.counts);
        let ratios = city.ratios();
        let ratio = |i: usize| i.checked_sub(1).map(|before| ratios[before]);
        for (i, &(far_dist, count)) in city.counts.iter().enumerate() {
            let fitted = model.scale * (far_dist + model.node_size).powi(2);
            rows.push(vec![
                city.name.clone(),
                city.objects.to_string(),
                far_dist.to_string(),
                format!("{count:.0}"),
                ratio(i).map_or("-".into(), |r| format!("{r:.2}")),
                finite(fitted, 0),
            ]);
        }
        let mean_ratio = city.mean_ratio();
        let _ = write!(
            text,
            "\n{} ({} objects): mean ratio {mean_ratio:.2}, exponent {exponent:.2}, s = {} m, \
             R2 = {}",
            city.name,
            thousands(city.objects.into()),
            finite(model.node_size, 0),
            finite(model.r2, 4)
        );
        scenes.push(json!({
            "name": city.name,
            "objects": city.objects,
            "rows": city.counts.iter().enumerate().map(|(i, &(far_dist_m, count))| json!({
                "far_dist_m": far_dist_m, "count": count, "ratio": ratio(i),
            })).collect::<Vec<_>>(),
            "mean_ratio": mean_ratio,
            "exponent": exponent,
            "node_size_m": model.node_size,
            "r2": model.r2,
        }));
        series.push(Series {
            name: format!("{}, {} objects", city.name, thousands(city.objects.into())),
            points: city.counts.clone(),
            reference: false,
        });
    }
    if let Some(&(first, count)) = cities.last().and_then(|city| city.counts.first()) {
        series.push(Series {
            name: "theory: far_dist²".into(),
            points: FAR_DISTS_M
                .iter()
                .map(|d| (*d, count * (d / first).powi(2)))
                .collect(),
            reference: true,
        });
    }
    let labels = Labels {
        title: "Objects drawn against far_dist",
        x: "far_dist, m",
        y: "objects drawn",
    };
    let parameters = json!({
        "far_dists_m": FAR_DISTS_M, "dist_factor": DIST_FACTOR, "views": PLACES * 4,
    });
    Ok(Report {
        name: "far-dist",
        text,
        tables: vec![Table {
            columns: vec!["city", "objects", "far_dist_m", "count", "ratio", "model"],
            rows,
            ..Table::default()
        }],
        plots: vec![Plot {
            svg: plot::log_log(&labels, &series)?,
            ..Plot::default()
        }],
        json: json!({ "scenes": scenes, "circumstances": circumstances(&parameters) }),
        ..Report::default()
    })
}
