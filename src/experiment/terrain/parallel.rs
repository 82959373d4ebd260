//! Refinement by one thread and by several (D, table 3).

use rayon::ThreadPoolBuilder;
use serde_json::json;

use super::place::{mountains, overview};
use crate::experiment::report::{Table, circumstances, thousands};
use crate::experiment::timing::{median, seconds};
use crate::experiment::{Options, Progress, Report, ReportError};
use crate::terrain::{Criterion, Detail, Workers, refine};

const SAMPLES: usize = 15;

struct Row {
    criterion: Criterion,
    threads: usize,
    splits: usize,
    refine_us: f64,
    speedup: f64,
    same: bool,
}

pub(in crate::experiment) fn run(
    options: &Options,
    progress: &Progress,
) -> Result<Report, ReportError> {
    let (field, ground) = mountains(options)?;
    let view = overview(&field)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut counts: Vec<usize> = vec![2, 4, cores];
    counts.sort_unstable();
    counts.dedup();
    let mut rows = Vec::new();
    for criterion in [Criterion::Error, Criterion::Vertex] {
        let detail = Detail {
            knobs: criterion.share(&criterion.knobs(), 8.0),
            ..Detail::of(criterion)
        };
        let serial = refine(&ground, &view, &detail, Workers::One)?;
        let levels = 0..ground.layout().levels();
        let splits = levels.map(|level| serial.splits(level).count()).sum();
        for &threads in &counts {
            progress(&format!("{}, {threads} threads", criterion.name()));
            let pool = ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map_err(|error| ReportError::Threads(error.to_string()))?;
            let parallel = || pool.install(|| refine(&ground, &view, &detail, Workers::Pool));
            let same = parallel()? == serial;
            // Turn by turn, so that both meet the same neighbours on the machine.
            let turns = (0..SAMPLES).map(|_| {
                let (one, _) = seconds(|| refine(&ground, &view, &detail, Workers::One));
                let (many, _) = seconds(parallel);
                (one * 1e6, many * 1e6)
            });
            let (one, many): (Vec<f64>, Vec<f64>) = turns.unzip();
            let (one, many) = (median(one), median(many));
            if threads == counts[0] {
                rows.push(Row {
                    criterion,
                    threads: 1,
                    splits,
                    refine_us: one,
                    speedup: 1.0,
                    same: true,
                });
            }
            rows.push(Row {
                criterion,
                threads,
                splits,
                refine_us: many,
                speedup: one / many,
                same,
            });
        }
    }
    Ok(report(&rows, field.grid().count(), cores))
}

fn report(rows: &[Row], posts: usize, cores: usize) -> Report {
    let text = format!(
        "{} posts in one view, {cores} cores; medians of {SAMPLES}, serial and parallel in turn. \
         Speed-up against the serial time of the same turns.",
        thousands(posts as u64)
    );
    let cells = rows.iter().map(|row| {
        vec![
            row.criterion.name().to_owned(),
            row.threads.to_string(),
            thousands(row.splits as u64),
            format!("{:.0}", row.refine_us),
            format!("{:.2}", row.speedup),
            row.same.to_string(),
        ]
    });
    let json_rows = rows.iter().map(|row| {
        json!({
            "criterion": row.criterion.name(), "threads": row.threads, "splits": row.splits,
            "refine_us": row.refine_us, "speedup": row.speedup, "same": row.same,
        })
    });
    Report {
        name: "terrain-parallel",
        text,
        json: json!({
            "rows": json_rows.collect::<Vec<_>>(),
            "circumstances": circumstances(&json!({ "posts": posts, "samples": SAMPLES })),
        }),
        tables: vec![Table {
            columns: vec![
                "criterion",
                "threads",
                "splits",
                "refine_us",
                "speedup",
                "same",
            ],
            rows: cells.collect(),
            ..Table::default()
        }],
        ..Report::default()
    }
}
