//! What it brings to keep the tiles that were read (A, table 1), and what it takes (D, table 3).
//!
//! A flight of ten positions, 30 frames from each to the next. A frame is A's walk through the
//! tree and ends with the tiles ready to draw; drawing is not in it, as it is the same whatever
//! way the tiles come. Stores start empty, so that their own reading is in their time.

use serde_json::json;

use super::memory;
use super::place::{POSITIONS, flight_of, mountains};
use super::supply::{Supply, Way, export};
use crate::experiment::report::{Table, circumstances, thousands};
use crate::experiment::timing::{median, seconds};
use crate::experiment::{Options, Progress, Report, ReportError};
use crate::geom::View;
use crate::terrain::pyramid::{Pyramid, Tiling, write};
use crate::terrain::{Criterion, Knobs};

const FRAMES: usize = 30;
const SAMPLES: usize = 5;
/// Share of A's detail that gives as many triangles as its table.
pub(super) const SHARE: f64 = 0.02;
/// A's lowest ratio of frame rates.
const PAPER_RATIO: f64 = 5.8;

/// One position and the frames to the next.
struct Leg {
    triangles: usize,
    /// Frames a second, in the order of [`Way::ALL`].
    fps: [f64; 4],
}

impl Leg {
    /// Of A's stores to A's reading again.
    fn ratio(&self) -> f64 {
        self.fps[2] / self.fps[0]
    }
}

pub(in crate::experiment) fn run(
    options: &Options,
    progress: &Progress,
) -> Result<Report, ReportError> {
    let folder = tempfile::tempdir();
    let folder = folder.map_err(|source| ReportError::Write {
        path: std::env::temp_dir(),
        source,
    })?;
    // First, while little else has been in memory.
    let most = options.largest.unwrap_or(u32::MAX);
    let memory = memory::rows(folder.path(), most, progress)?;
    let (field, _) = mountains(options)?;
    let path = folder.path().join("mountains.terrain");
    progress("the pyramid");
    let tiling = Tiling::new(*field.grid());
    let height = |column, row| field.height(column, row);
    write(&path, &tiling, None, height, &|_, _| {})?;
    let pyramid = Pyramid::open(&path)?;
    export(&pyramid, folder.path())?;
    let views = flight_of(&field, POSITIONS * FRAMES as u32)?;
    let knobs = Criterion::Roughness.share(&Criterion::Roughness.knobs(), SHARE);
    let flights = Flights {
        pyramid: &pyramid,
        files: folder.path(),
        views: &views,
        knobs: &knobs,
    };
    progress("the same tiles in every way");
    let Compared {
        counts,
        differing,
        read,
    } = flights.compare()?;
    let mut fps = Vec::new();
    for way in Way::ALL {
        progress(&format!("tiles by {}", way.name()));
        fps.push(flights.fps(way)?);
    }
    let legs = counts.chunks(FRAMES).enumerate().map(|(leg, counts)| Leg {
        triangles: counts[0] << (2 * tiling.tile_levels() + 1),
        fps: std::array::from_fn(|way| fps[way][leg]),
    });
    let legs: Vec<Leg> = legs.collect();
    Ok(report(
        &legs,
        differing,
        read,
        &memory,
        field.grid().count(),
    ))
}

struct Compared {
    /// Tiles drawn in each frame.
    counts: Vec<usize>,
    /// Frames in which the ways differ in any vertex.
    differing: usize,
    /// Tiles read in the order of [`Way::ALL`].
    read: [u64; 4],
}

struct Flights<'a> {
    pyramid: &'a Pyramid,
    files: &'a std::path::Path,
    views: &'a [View],
    knobs: &'a Knobs,
}

impl Flights<'_> {
    fn compare(&self) -> Result<Compared, ReportError> {
        let mut supplies = Way::ALL.map(|way| Supply::new(way, self.pyramid, self.files));
        let mut counts = Vec::new();
        let mut differing = 0;
        for view in self.views {
            let mut frames = Vec::new();
            for supply in &mut supplies {
                frames.push(supply.frame(view, self.knobs)?);
            }
            counts.push(frames[0].len());
            differing += usize::from(frames.iter().any(|frame| *frame != frames[0]));
        }
        Ok(Compared {
            counts,
            differing,
            read: supplies.map(|supply| supply.read()),
        })
    }

    /// Frames a second of each leg: the median of several flights.
    fn fps(&self, way: Way) -> Result<Vec<f64>, ReportError> {
        let mut legs = vec![Vec::new(); self.views.len() / FRAMES];
        for _ in 0..SAMPLES {
            let mut supply = Supply::new(way, self.pyramid, self.files);
            for (views, fps) in self.views.chunks(FRAMES).zip(&mut legs) {
                let (taken, flown) = seconds(|| {
                    views.iter().try_for_each(|view| {
                        std::hint::black_box(supply.frame(view, self.knobs)?);
                        Ok::<_, ReportError>(())
                    })
                });
                flown?;
                fps.push(views.len() as f64 / taken);
            }
        }
        Ok(legs.into_iter().map(median).collect())
    }
}

/// Largest difference from the first, %.
fn spread_pct(numbers: impl Iterator<Item = f64> + Clone) -> f64 {
    let first = numbers.clone().next().unwrap_or(f64::NAN);
    numbers.fold(0.0, |worst, number| {
        worst.max(100.0 * (number / first - 1.0).abs())
    })
}

fn report(
    legs: &[Leg],
    differing: usize,
    read: [u64; 4],
    memory: &[memory::Row],
    posts: usize,
) -> Report {
    let least = legs.iter().map(Leg::ratio).fold(f64::INFINITY, f64::min);
    let held_spread = spread_pct(memory.iter().map(|row| row.held_bytes as f64));
    let flying = memory.iter().filter_map(|row| row.flight_bytes);
    let flight_spread = spread_pct(flying.map(|bytes| bytes as f64));
    let growth = memory.last().map_or(1.0, |row| row.growth);
    let text = format!(
        "{} posts. Frames a second with tiles in stores by level (A) against tiles read again from\n\
         files of their own: at least {least:.1} times, in the paper {PAPER_RATIO}. The ways differ in\n\
         {differing} of {} frames. As the ground grows {growth:.1} times, the memory of the queue (D) changes by\n\
         {held_spread:.1} %, and that of the whole process in flight by {flight_spread:.1} %.",
        thousands(posts as u64),
        legs.len() * FRAMES,
    );
    let cells = legs.iter().enumerate().map(|(position, leg)| {
        let mut cells = vec![position.to_string(), thousands(leg.triangles as u64)];
        cells.extend(leg.fps.map(|fps| format!("{fps:.0}")));
        cells.push(format!("{:.1}", leg.ratio()));
        cells
    });
    let megabytes = |bytes: f64| format!("{:.1}", bytes / 1e6);
    let maybe = |bytes: Option<u64>| bytes.map_or("-".into(), |bytes| megabytes(bytes as f64));
    let memory_cells = memory.iter().map(|row| {
        vec![
            format!("{:.1}", row.growth),
            megabytes(row.bytes as f64),
            thousands(row.tiles),
            row.held.to_string(),
            megabytes(row.held_bytes as f64),
            maybe(row.write_bytes),
            maybe(row.flight_bytes),
            maybe(row.mapped_bytes),
        ]
    });
    let json_rows = legs.iter().map(|leg| {
        let [files, anew, stores, queue] = leg.fps;
        json!({
            "triangles": leg.triangles, "files_fps": files, "anew_fps": anew,
            "stores_fps": stores, "queue_fps": queue, "ratio": leg.ratio(),
        })
    });
    let json_memory = memory.iter().map(|row| {
        json!({
            "growth": row.growth, "bytes": row.bytes, "tiles": row.tiles,
            "held_tiles": row.held, "held_bytes": row.held_bytes,
            "write_anonymous_bytes": row.write_bytes, "flight_anonymous_bytes": row.flight_bytes,
            "flight_mapped_bytes": row.mapped_bytes,
        })
    });
    Report {
        name: "terrain-store",
        text,
        json: json!({
            "rows": json_rows.collect::<Vec<_>>(),
            "least_ratio": least,
            "differing_frames": differing,
            "tiles_read": { "files": read[0], "anew": read[1], "stores": read[2], "queue": read[3] },
            "memory": json_memory.collect::<Vec<_>>(),
            "memory_spread_pct": held_spread,
            "flight_spread_pct": flight_spread,
            "circumstances": circumstances(&json!({
                "posts": posts, "positions": POSITIONS, "frames": FRAMES, "share": SHARE,
            })),
        }),
        tables: vec![
            Table {
                columns: vec![
                    "position",
                    "triangles",
                    "files_fps",
                    "anew_fps",
                    "stores_fps",
                    "queue_fps",
                    "ratio",
                ],
                rows: cells.collect(),
                ..Table::default()
            },
            Table {
                name: "memory",
                title: "Memory as the ground grows, MB: tiles held, the process while writing and flying, \
                        the file in memory"
                    .into(),
                columns: vec![
                    "growth",
                    "file",
                    "tiles",
                    "held_tiles",
                    "held",
                    "writing",
                    "flying",
                    "mapped",
                ],
                rows: memory_cells.collect(),
            },
        ],
        ..Report::default()
    }
}
