//! What each effect costs: undeclared, declared and switched off, and on; and what occlusion
//! misses at each resolution of its id-buffer.
//!
//! Time varies from run to run; instructions do not. They are counted by callgrind around
//! [`crate::frame::Frame::work_out`] in the command itself, where valgrind is installed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::json;

use super::city::{self, GONG_OBJECTS};
use super::plot::{self, Labels, Series};
use super::report::{Plot, Table, circumstances, thousands};
use super::street::{self, Street};
use super::timing::median_us;
use super::{Options, Progress, Report, ReportError, hills};
use crate::effects::terrain::Land;
use crate::frame::{Active, Frame};
use crate::index::LodTree;
use crate::lod::{Lod, RangeLod};
use crate::scene::{Effects, Haze, Motion, Occlusion, Terrain};

const FAR_DIST_M: f64 = 500.0;
const SPEED_MPS: f64 = 6.0;
const SAMPLES: usize = 15;
const MOTION: Motion = Motion {
    reference_speed_mps: 1.5,
};
const HAZE: Haze = Haze {
    visibility_m: 600.0,
};
const OCCLUSION: Occlusion = Occlusion {
    width_px: 512,
    min_pixels: 1,
};
/// Widths of id-buffers whose answers are compared with one four times finer.
const WIDTHS_PX: [u32; 4] = [128, 256, 512, 1024];
const FINER: u32 = 4;
const STREETS: usize = 8;

/// One effect in one state.
struct Row {
    effect: &'static str,
    declared: bool,
    on: bool,
    count: u32,
    instructions: Option<u64>,
    frame_us: f64,
}

/// What occlusion finds at one resolution, over all views.
struct Resolution {
    width_px: u32,
    seen: usize,
    seen_finer: usize,
    /// Of those seen in the finer buffer.
    missed: usize,
    /// Most pixels in the finer buffer of an object that was missed.
    largest_missed_px: u32,
    hide_us: f64,
}

pub(super) fn run(options: &Options, progress: &Progress) -> Result<Report, ReportError> {
    let objects = GONG_OBJECTS.min(options.largest.unwrap_or(u32::MAX));
    progress(&format!(
        "generated city of {} objects",
        thousands(objects.into())
    ));
    let tree = city::generated(objects)?;
    let streets = street::views(&tree, STREETS)?;
    let Some(street) = streets.first() else {
        return Err(ReportError::Nothing("a street to stand in"));
    };
    let folder = tempfile::tempdir().map_err(|source| ReportError::Write {
        path: std::env::temp_dir(),
        source,
    })?;
    let counter = Counter::new(options.program.as_deref(), folder.path(), street);
    let mut rows = Vec::new();
    for (effect, declared) in [
        ("none", Effects::default()),
        ("motion", declaring(|e| e.motion = Some(MOTION))),
        ("haze", declaring(|e| e.haze = Some(HAZE))),
        ("occlusion", declaring(|e| e.occlusion = Some(OCCLUSION))),
        (
            "terrain",
            declaring(|e| e.terrain = Some(Terrain::default())),
        ),
    ] {
        progress(effect);
        let city = counter.city(effect, &tree, declared)?;
        if effect == "none" {
            rows.push(measure(effect, &tree, street, None, &counter, &city));
        } else {
            for active in [Active::default(), Active::all(&declared, SPEED_MPS)] {
                let row = measure(effect, &tree, street, Some(active), &counter, &city);
                rows.push(row);
            }
        }
    }
    let standing = streets.len();
    let mut resolutions = Vec::new();
    for width_px in WIDTHS_PX {
        progress(&format!("occlusion at {width_px} pixels"));
        resolutions.push(resolution(&tree, &streets, width_px));
    }
    report(objects, &rows, &resolutions, standing)
}

fn declaring(declare: impl FnOnce(&mut Effects)) -> Effects {
    let mut effects = Effects::default();
    declare(&mut effects);
    effects
}

fn lod() -> Lod {
    let range = RangeLod::default();
    let lod = RangeLod::new(FAR_DIST_M, range.dist_factor(), 4, range.beyond());
    Lod::Range(lod.unwrap_or(range))
}

/// `active` is `None` where nothing is declared.
fn measure(
    effect: &'static str,
    tree: &LodTree,
    street: &Street,
    active: Option<Active>,
    counter: &Counter,
    (city, land): &(PathBuf, Option<Land>),
) -> Row {
    let mut frame = Frame::default();
    let running = active.unwrap_or_default();
    let (view, lod, none) = (&street.view, lod(), || Duration::ZERO);
    let mut work = || match land {
        Some(land) => frame.work_out_on(land, tree, view, &lod, &running, none),
        None => frame.work_out(tree, view, &lod, &running, none),
    };
    let frame_us = median_us(SAMPLES, &mut work);
    let on = running != Active::default();
    let without = (active.is_some() && !on).then_some(effect);
    Row {
        effect,
        declared: active.is_some(),
        on,
        instructions: counter.count(city, without, running.motion.is_some()),
        count: frame.selection().count(),
        frame_us,
    }
}

fn resolution(tree: &LodTree, streets: &[Street], width_px: u32) -> Resolution {
    let mut found = Resolution {
        width_px,
        seen: 0,
        seen_finer: 0,
        missed: 0,
        largest_missed_px: 0,
        hide_us: 0.0,
    };
    let [mut coarse, mut fine] = [Frame::default(), Frame::default()];
    let active = |width_px| {
        let occlusion = Occlusion {
            width_px,
            ..OCCLUSION
        };
        Active::all(&declaring(|e| e.occlusion = Some(occlusion)), 0.0)
    };
    let mut times = Vec::new();
    for Street { view, .. } in streets {
        let none = || Duration::ZERO;
        fine.work_out(tree, view, &lod(), &active(width_px * FINER), none);
        times.push(median_us(SAMPLES.min(5), || {
            coarse.work_out(tree, view, &lod(), &active(width_px), none);
        }));
        let seen: Vec<u32> = coarse.selection().objects().collect();
        found.seen += seen.len();
        for &(object, pixels) in fine.visible_pixels() {
            found.seen_finer += 1;
            if seen.binary_search(&object).is_err() {
                found.missed += 1;
                found.largest_missed_px = found.largest_missed_px.max(pixels);
            }
        }
    }
    found.hide_us = super::timing::median(times);
    found
}

/// Counts the instructions of a query.
struct Counter<'a> {
    program: Option<&'a Path>,
    folder: &'a Path,
    street: &'a Street,
}

impl<'a> Counter<'a> {
    fn new(program: Option<&'a Path>, folder: &'a Path, street: &'a Street) -> Self {
        let mut valgrind = Command::new("valgrind");
        let there = valgrind.arg("--version").stdout(Stdio::null()).status();
        Self {
            program: program.filter(|_| there.is_ok_and(|status| status.success())),
            folder,
            street,
        }
    }

    /// Writes the city with what it declares, on hills where that is terrain.
    fn city(
        &self,
        name: &str,
        tree: &LodTree,
        mut declared: Effects,
    ) -> Result<(PathBuf, Option<Land>), ReportError> {
        let path = self.folder.join(format!("{name}.citylod"));
        let mut land = None;
        if let Some(terrain) = &mut declared.terrain {
            let pyramid = hills::lay(&path, &tree.bounds())?;
            terrain.ground = Some(pyramid.checksum());
            land = Some(Land::new(pyramid)?);
        }
        tree.declaring(declared).save(&path)?;
        Ok((path, land))
    }

    /// Instructions of one frame whose memory is there already; `None` where they cannot be
    /// counted.
    fn count(&self, city: &Path, without: Option<&str>, moves: bool) -> Option<u64> {
        let [three, two] = [3, 2].map(|frames| self.frames(frames, city, without, moves));
        three?.checked_sub(two?).filter(|&one| one > 0)
    }

    /// Instructions of so many frames, one after another.
    fn frames(&self, frames: u32, city: &Path, without: Option<&str>, moves: bool) -> Option<u64> {
        let program = self.program?;
        let out = self.folder.join("callgrind.out");
        let point = |p: crate::geom::DVec3| format!("{},{},{}", p.x, p.y, p.z);
        let mut valgrind = Command::new("valgrind");
        valgrind
            .args(["--tool=callgrind", "--toggle-collect=*Frame*work_out*"])
            .arg(format!("--callgrind-out-file={}", out.display()))
            .arg(program)
            .arg("query")
            .arg(city)
            .args(["--eye", &point(self.street.eye)])
            .args(["--target", &point(self.street.target)])
            .args(["--far-dist", &FAR_DIST_M.to_string()])
            .args(["--repeat", &frames.to_string()])
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        if moves {
            valgrind.args(["--speed", &SPEED_MPS.to_string()]);
        }
        if let Some(effect) = without {
            valgrind.args(["--without", effect]);
        }
        let ran = valgrind.status().is_ok_and(|status| status.success());
        let counted = std::fs::read_to_string(&out).ok().filter(|_| ran);
        counted.as_deref().and_then(total)
    }
}

/// The sum at the end of callgrind's file.
fn total(file: &str) -> Option<u64> {
    let line = file.lines().find_map(|line| line.strip_prefix("totals: "));
    line.and_then(|number| number.trim().parse().ok())
}

fn report(
    objects: u32,
    rows: &[Row],
    resolutions: &[Resolution],
    streets: usize,
) -> Result<Report, ReportError> {
    let base = rows.first().and_then(|row| row.instructions);
    let ratio = |row: &Row| Some(row.instructions? as f64 / base? as f64);
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".into());
    let recall =
        |r: &Resolution| 100.0 * (r.seen_finer - r.missed) as f64 / (r.seen_finer as f64).max(1.0);
    let dash = || "-".to_owned();
    let effects = rows.iter().map(|row| {
        vec![
            row.effect.into(),
            if row.declared { "yes" } else { "no" }.into(),
            if row.on { "yes" } else { "no" }.into(),
            thousands(row.count.into()),
            or_dash(row.instructions.map(thousands)),
            or_dash(ratio(row).map(|r| format!("{r:.4}"))),
            format!("{:.1}", row.frame_us),
            dash(),
            dash(),
        ]
    });
    let widths = resolutions.iter().map(|r| {
        vec![
            format!("occlusion, {} px", r.width_px),
            "yes".into(),
            "yes".into(),
            thousands((r.seen / streets) as u64),
            dash(),
            dash(),
            format!("{:.1}", r.hide_us),
            format!("{:.1}", recall(r)),
            r.largest_missed_px.to_string(),
        ]
    });
    let text = format!(
        "What each effect costs in a generated city of {} objects, seen from a street, range mode, \
         far_dist {FAR_DIST_M} m.\nInstructions are those of one frame, counted by callgrind; \
         ratio is against a scene that declares nothing. Time is a median.\nOcclusion by width of \
         its id-buffer, {streets} streets: recall of what a buffer {FINER} times finer shows, and \
         the most pixels there of an object that was missed.",
        thousands(objects.into())
    );
    let json_rows = rows.iter().map(|row| {
        json!({
            "effect": row.effect, "declared": row.declared, "on": row.on,
            "count": row.count, "instructions": row.instructions,
            "instructions_ratio": ratio(row), "retrieve_us": row.frame_us,
        })
    });
    let json_resolutions = resolutions.iter().map(|r| {
        json!({
            "width_px": r.width_px, "seen": r.seen, "seen_finer": r.seen_finer,
            "missed": r.missed, "recall_pct": recall(r),
            "largest_missed_px": r.largest_missed_px, "retrieve_us": r.hide_us,
        })
    });
    let parameters = json!({
        "objects": objects, "far_dist_m": FAR_DIST_M, "speed_mps": SPEED_MPS,
        "streets": streets, "finer": FINER,
    });
    let series = [Series {
        name: format!("objects missed, of those a buffer {FINER} times finer shows"),
        points: resolutions
            .iter()
            .map(|r| (r.hide_us, (100.0 - recall(r)).max(0.01)))
            .collect(),
        reference: false,
    }];
    let labels = Labels {
        title: "What occlusion misses against what it takes",
        x: "time of a frame, us",
        y: "objects missed, %",
    };
    Ok(Report {
        name: "effects",
        text,
        tables: vec![Table {
            columns: vec![
                "effect",
                "declared",
                "on",
                "drawn",
                "instructions",
                "ratio",
                "frame_us",
                "recall_pct",
                "largest_missed_px",
            ],
            rows: effects.chain(widths).collect(),
            ..Table::default()
        }],
        json: json!({
            "rows": json_rows.collect::<Vec<_>>(),
            "occlusion": json_resolutions.collect::<Vec<_>>(),
            "circumstances": circumstances(&parameters),
        }),
        plots: vec![Plot {
            svg: plot::log_log(&labels, &series)?,
            ..Plot::default()
        }],
        ..Report::default()
    })
}
