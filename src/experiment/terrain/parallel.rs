//! Refinement by one thread and by several (D, table 3).

use rayon::ThreadPoolBuilder;
use serde_json::json;

use super::place::{mountains, overview};
use crate::experiment::report::{Table, circumstances, thousands};
use crate::experiment::timing::{median, seconds};
use crate::experiment::{Options, Progress, Report, ReportError};
use crate::geom::View;
use crate::terrain::{Criterion, Detail, Ground, Layout, Workers, refine};

/// Several pools, as the system may put all threads of one on one core.
const POOLS: usize = 9;
const TURNS: usize = 9;
/// Of each criterion's own detail: a selection of some ten milliseconds.
const SHARE: f64 = 64.0;

struct Row {
    blocks: usize,
    criterion: Criterion,
    threads: usize,
    splits: usize,
    refine_us: f64,
    /// Serial over parallel time: median and quartiles over the turns.
    speedup: [f64; 3],
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
    let largest = Layout::with_levels(*field.grid(), Layout::MOST_LEVELS);
    let mut rows = Vec::new();
    for ground in [&ground, &Ground::cut(&field, &largest)] {
        for criterion in Criterion::ALL {
            progress(&format!(
                "{} blocks, {}",
                ground.layout().block_count(),
                criterion.name()
            ));
            let detail = Detail {
                knobs: criterion.share(&criterion.knobs(), SHARE),
                ..Detail::of(criterion)
            };
            rows.extend(timed(ground, &view, &detail, &counts)?);
        }
    }
    Ok(report(&rows, field.grid().count(), cores))
}

fn timed(
    ground: &Ground,
    view: &View,
    detail: &Detail,
    counts: &[usize],
) -> Result<Vec<Row>, ReportError> {
    let serial = refine(ground, view, detail, Workers::One)?;
    let levels = 0..ground.layout().levels();
    let row = |threads, refine_us, speedup, same| Row {
        blocks: ground.layout().block_count(),
        criterion: detail.criterion,
        threads,
        splits: levels
            .clone()
            .map(|level| serial.splits(level).count())
            .sum(),
        refine_us,
        speedup,
        same,
    };
    let mut rows = Vec::new();
    for &threads in counts {
        let (mut one, mut many, mut same) = (Vec::new(), Vec::new(), true);
        for _ in 0..POOLS {
            let pool = ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map_err(|error| ReportError::Threads(error.to_string()))?;
            let parallel = || pool.install(|| refine(ground, view, detail, Workers::Pool));
            same &= parallel()? == serial;
            // Turn by turn, so that both meet the same neighbours on the machine.
            for _ in 0..TURNS {
                one.push(seconds(|| refine(ground, view, detail, Workers::One)).0 * 1e6);
                many.push(seconds(parallel).0 * 1e6);
            }
        }
        let ratios = one.iter().zip(&many).map(|(one, many)| one / many);
        let mut ratios: Vec<f64> = ratios.collect();
        ratios.sort_by(f64::total_cmp);
        let speedup = [2, 1, 3].map(|quarters| ratios[ratios.len() * quarters / 4]);
        if rows.is_empty() {
            rows.push(row(1, median(one), [1.0; 3], true));
        }
        rows.push(row(threads, median(many), speedup, same));
    }
    Ok(rows)
}

fn report(rows: &[Row], posts: usize, cores: usize) -> Report {
    let text = format!(
        "{} posts in one view, in blocks of C's size and in the largest, {cores} cores. Serial and \
         parallel in turn, {TURNS} turns in each of {POOLS} pools;\nmedians, and the speed-up is that of \
         the turns' ratios, with its quartiles.",
        thousands(posts as u64)
    );
    let cells = rows.iter().map(|row| {
        let mut cells = vec![
            row.blocks.to_string(),
            row.criterion.name().to_owned(),
            row.threads.to_string(),
            thousands(row.splits as u64),
            format!("{:.0}", row.refine_us),
        ];
        cells.extend(row.speedup.map(|ratio| format!("{ratio:.2}")));
        cells.push(row.same.to_string());
        cells
    });
    let json_rows = rows.iter().map(|row| {
        let [speedup, low, high] = row.speedup;
        json!({
            "blocks": row.blocks, "criterion": row.criterion.name(), "threads": row.threads,
            "splits": row.splits, "refine_us": row.refine_us, "speedup": speedup,
            "speedup_quartiles": [low, high], "same": row.same,
        })
    });
    Report {
        name: "terrain-parallel",
        text,
        json: json!({
            "rows": json_rows.collect::<Vec<_>>(),
            "circumstances": circumstances(&json!({ "posts": posts, "pools": POOLS, "turns": TURNS, "share": SHARE })),
        }),
        tables: vec![Table {
            columns: vec![
                "blocks",
                "criterion",
                "threads",
                "splits",
                "refine_us",
                "speedup",
                "lower_quartile",
                "upper_quartile",
                "same",
            ],
            rows: cells.collect(),
            ..Table::default()
        }],
        ..Report::default()
    }
}
