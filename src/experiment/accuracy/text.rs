//! What the tables say, in sentences.

use std::fmt::Write as _;

use super::Measured;
use super::full_detail::{DISTRICT_M, FAR_M};
use super::rows::{Cost, Row, Summary};
use super::strategy::Strategy;
use super::viewpoint::VIEWPORT;
use crate::experiment::report::thousands;

/// Objects drawn where one number has to do.
const EXAMPLE: usize = 5_000;

pub(super) fn text(measured: &Measured, summaries: &[Summary]) -> String {
    let [width, height] = VIEWPORT;
    let mut out = format!(
        "Each answer is drawn at {width} x {height} and compared pixel by pixel with a picture of \
         every object, in eight views of each city: street, roof, bird's eye, far and map. Missed: \
         of the pixels that show the city, those that show another object or none; coverage error: \
         those that show none. Worst missed: how far what full detail shows of an object that is \
         not drawn extends on the screen; bound: the size that the answer certifies no such object \
         to exceed."
    );
    let _ = write!(out, "\n\n{}", bound(&measured.rows));
    for of_scene in summaries.chunk_by(|a, b| a.scene == b.scene) {
        let _ = write!(out, "\n\n{}", missed(of_scene));
        if let Some(text) = far_field(of_scene) {
            let _ = write!(out, " {text}");
        }
    }
    for costs in measured.costs.chunk_by(|a, b| a.scene == b.scene) {
        let _ = write!(out, "\n\n{}", takes(costs));
    }
    if !measured.speeds.is_empty() {
        out += "\n\nBeside looking at every object, size first, for the same answer: one at a time from \
             its box in f64, and eight at a time in f32 from tables made for it; and budget mode \
             beside error mode, both in a frame loop and both in their first frame:";
    }
    for speed in &measured.speeds {
        let _ = write!(
            out,
            "\n{} of {} objects: error mode {:.0} µs, one at a time {:.0} times as long, eight at \
             a time {:.0} times (at least {:.0}), budget mode {:.1} times (at most {:.1}), in the \
             first frame {:.1} times.",
            thousands(speed.count as u64),
            thousands(speed.objects.into()),
            speed.error_us,
            speed.plain_over_error,
            speed.linear_over_error,
            speed.lowest_linear_over_error,
            speed.moving_budget_over_error,
            speed.highest_moving_budget_over_error,
            speed.first_budget_over_error
        );
    }
    out
}

/// Whether the certified bound held.
fn bound(rows: &[Row]) -> String {
    let broken = |row: &&Row| row.worst_missed_px > row.bound_px;
    let certified: Vec<&Row> = rows.iter().filter(|r| !r.strategy.is_reference()).collect();
    let broken = certified.iter().copied().filter(broken).count();
    let count = thousands(certified.len() as u64);
    match broken {
        0 => format!("In none of {count} answers was anything missed that exceeds the bound."),
        _ => format!("In {broken} of {count} answers something missed exceeds the bound."),
    }
}

fn of(summaries: &[Summary], strategy: Strategy, asked: usize) -> Option<&Summary> {
    summaries
        .iter()
        .find(|s| s.strategy == strategy && s.asked == asked)
}

/// What each strategy misses at one number of objects.
fn missed(summaries: &[Summary]) -> String {
    let mut shares = String::new();
    for (name, strategy) in [
        ("error and budget mode", Strategy::Error),
        ("range mode by the tallest", Strategy::RangeTallest),
        ("by the largest footprint", Strategy::RangeFootprint),
        ("one size for all distances", Strategy::GlobalSize),
        ("a random choice", Strategy::Random),
    ] {
        if let Some(summary) = of(summaries, strategy, EXAMPLE) {
            let comma = if shares.is_empty() { "" } else { "," };
            let _ = write!(shares, "{comma} {name} {:.1} %", summary.missed_px_pct);
        }
    }
    let scene = &summaries[0].scene;
    let count = thousands(EXAMPLE as u64);
    format!("{scene}, with {count} objects a view. Missed pixels:{shares}.")
}

/// What it takes to miss less and less in error mode, and how range mode compares.
fn takes(costs: &[Cost]) -> String {
    let of = |strategy, missed| {
        let same = |c: &&Cost| c.strategy == strategy && c.missed_px_pct == missed;
        costs.iter().find(same)
    };
    let mut steps = String::new();
    for missed in [30.0, 10.0, 1.0, 0.1] {
        if let (Some(error), Some(range)) = (
            of(Strategy::Error, missed),
            of(Strategy::RangeTallest, missed),
        ) {
            let _ = write!(
                steps,
                "\nTo miss {missed} %: error mode {} objects in {:.0} µs, range mode by the tallest \
                 {} in {:.0} µs.",
                thousands(error.count as u64),
                error.retrieve_us,
                thousands(range.count as u64),
                range.retrieve_us
            );
        }
    }
    format!(
        "{}, one parameter for all views, means of the views.{steps}",
        costs[0].scene
    )
}

/// From where on range mode keeps more of the far field than error mode.
fn far_field(summaries: &[Summary]) -> Option<String> {
    let pairs: Vec<[&Summary; 2]> = summaries
        .iter()
        .filter(|s| s.strategy == Strategy::RangeTallest)
        .filter_map(|range| Some([range, of(summaries, Strategy::Error, range.asked)?]))
        .collect();
    let gain = |[range, error]: &[&Summary; 2]| {
        Some(range.far_districts_kept_pct? - error.far_districts_kept_pct?)
    };
    let far = pairs.first()?[0].far_districts;
    let largest = pairs.iter().max_by(|a, b| {
        let gains = [a, b].map(|pair| gain(pair).unwrap_or(0.0));
        gains[0].total_cmp(&gains[1])
    })?;
    let [range, error] = largest;
    let (most_range, most_error) = (range.far_districts_kept_pct?, error.far_districts_kept_pct?);
    let mut text = format!(
        "In view are {far:.0} far districts, squares of {DISTRICT_M} m beyond {FAR_M} m: with {} \
         objects range mode keeps something of {most_range:.0} % of them, error mode of \
         {most_error:.0} %.",
        thousands(range.asked as u64)
    );
    let better = pairs
        .iter()
        .take_while(|pair| gain(pair).is_some_and(|gain| gain > 0.0));
    let _ = match better.last() {
        None => write!(text, " Error mode keeps as many or more at every count."),
        Some([upto, _]) if upto.asked == pairs[pairs.len() - 1][0].asked => {
            write!(text, " Range mode keeps more of them at every count.")
        }
        Some([upto, _]) => write!(
            text,
            " Range mode keeps more of them up to {} objects, {:.0} for each.",
            thousands(upto.asked as u64),
            upto.count / far
        ),
    };
    Some(text)
}
