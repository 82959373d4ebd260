//! Plots in logarithmic axes, as SVG.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::ReportError;

/// A line with its name.
pub(super) struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    /// Drawn thin and without marks: theory, or a baseline.
    pub reference: bool,
}

pub(super) struct Labels<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
}

/// Colours that people with colour blindness can tell apart (Okabe and Ito, 2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(120, 120, 120),
];

/// Draws the series, both axes logarithmic.
pub(super) fn log_log(labels: &Labels, series: &[Series]) -> Result<String, ReportError> {
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (860, 520)).into_drawing_area();
    draw(&root, labels, series).map_err(|e| ReportError::Plot(e.to_string()))?;
    drop(root);
    Ok(svg)
}

/// Draws panels one above the other over the numbers of frames; upward axes are logarithmic.
pub(super) fn over_frames(panels: &[(Labels, Vec<Series>)]) -> Result<String, ReportError> {
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (860, 640)).into_drawing_area();
    let areas = root.split_evenly((panels.len().max(1), 1));
    for (area, (labels, series)) in areas.iter().zip(panels) {
        draw_frames(area, labels, series).map_err(|e| ReportError::Plot(e.to_string()))?;
    }
    drop(areas);
    // Once for all panels: presenting ends the document.
    root.present()
        .map_err(|e| ReportError::Plot(e.to_string()))?;
    drop(root);
    Ok(svg)
}

fn draw_frames<'a>(
    area: &DrawingArea<SVGBackend<'a>, Shift>,
    labels: &Labels,
    series: &[Series],
) -> Result<(), DrawError<'a>> {
    let points = || series.iter().flat_map(|s| &s.points);
    let last = points().map(|p| p.0).fold(1.0, f64::max);
    let low = points().map(|p| p.1).fold(f64::MAX, f64::min);
    let high = points().map(|p| p.1).fold(0.0, f64::max);
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(area)
        .caption(labels.title, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..last, (low / 1.2..high * 1.2).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(RGBColor(238, 238, 238))
        .bold_line_style(RGBColor(215, 215, 215))
        .max_light_lines(0)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 16))
        .x_desc(labels.x)
        .y_desc(labels.y)
        .x_label_formatter(&|v| format!("{v:.0}"))
        .y_label_formatter(&|v| short(*v))
        .draw()?;
    // The first is what it is about: drawn last, above the others.
    let lines: Vec<_> = series.iter().zip(COLOURS.iter().cycle()).collect();
    for (line, colour) in lines.into_iter().rev() {
        let style = if line.reference {
            RGBColor(120, 120, 120).stroke_width(1)
        } else {
            colour.stroke_width(2)
        };
        chart
            .draw_series(LineSeries::new(line.points.iter().copied(), style))?
            .label(&line.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .label_font(("sans-serif", 14))
        .background_style(WHITE.mix(0.9))
        .border_style(RGBColor(200, 200, 200))
        .draw()?;
    Ok(())
}

type DrawError<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;

fn draw<'a>(
    root: &DrawingArea<SVGBackend<'a>, Shift>,
    labels: &Labels,
    series: &[Series],
) -> Result<(), DrawError<'a>> {
    let range = |axis: fn(&(f64, f64)) -> f64| {
        let values = series.iter().flat_map(|s| s.points.iter().map(axis));
        let values = values.filter(|v| *v > 0.0 && v.is_finite());
        let (low, high) = values.fold((f64::MAX, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
        low / 1.3..high * 1.3
    };
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(root)
        .caption(labels.title, ("sans-serif", 22))
        .margin(16)
        .x_label_area_size(46)
        .y_label_area_size(78)
        .build_cartesian_2d(range(|p| p.0).log_scale(), range(|p| p.1).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(RGBColor(238, 238, 238))
        .bold_line_style(RGBColor(215, 215, 215))
        .x_labels(12)
        .y_labels(12)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 16))
        .x_desc(labels.x)
        .y_desc(labels.y)
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .draw()?;
    for (line, colour) in series.iter().zip(COLOURS.iter().cycle()) {
        let width = if line.reference { 1 } else { 3 };
        let style = colour.stroke_width(width);
        chart
            .draw_series(LineSeries::new(line.points.iter().copied(), style))?
            .label(&line.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], style));
        if !line.reference {
            let marks = line
                .points
                .iter()
                .map(|&p| Circle::new(p, 4, colour.filled()));
            chart.draw_series(marks)?;
        }
    }
    chart
        .configure_series_labels()
        .position(emptiest_corner(series))
        .label_font(("sans-serif", 14))
        .background_style(WHITE.mix(0.9))
        .border_style(RGBColor(200, 200, 200))
        .draw()?;
    root.present()
}

/// Where the legend hides fewest points: a corner takes about two fifths of each axis.
fn emptiest_corner(series: &[Series]) -> SeriesLabelPosition {
    const SHARE: f64 = 0.4;
    let points = series.iter().flat_map(|s| &s.points);
    let points: Vec<[f64; 2]> = points
        .filter(|(x, y)| *x > 0.0 && *y > 0.0)
        .map(|(x, y)| [x.ln(), y.ln()])
        .collect();
    // Along an axis: how far from either end, 0 to 1.
    let from_ends = |axis: usize, value: f64| {
        let values = points.iter().map(|p| p[axis]);
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = values.fold(start, |(l, h), v| (l.min(v), h.max(v)));
        let share = (value - low) / (high - low);
        [share, 1.0 - share]
    };
    let hidden = |right: usize, upper: usize| {
        let near =
            |p: &&[f64; 2]| from_ends(0, p[0])[right] < SHARE && from_ends(1, p[1])[upper] < SHARE;
        points.iter().filter(near).count()
    };
    let corners = [
        (SeriesLabelPosition::UpperLeft, hidden(0, 1)),
        (SeriesLabelPosition::UpperRight, hidden(1, 1)),
        (SeriesLabelPosition::LowerLeft, hidden(0, 0)),
        (SeriesLabelPosition::LowerRight, hidden(1, 0)),
    ];
    let emptiest = corners.into_iter().min_by_key(|corner| corner.1);
    emptiest.map_or(SeriesLabelPosition::UpperLeft, |corner| corner.0)
}

/// The same drawing in the colours of a page that may be light or dark: what is white here takes
/// the page's `--card`, lines its `--fine` and `--line`, text its own.
pub(super) fn for_pages(svg: &str) -> String {
    [
        ("#FFFFFF", "var(--card)"),
        ("#000000", "currentColor"),
        ("#EEEEEE", "var(--fine)"),
        ("#D7D7D7", "var(--line)"),
        ("#C8C8C8", "var(--line)"),
    ]
    .into_iter()
    .fold(svg.to_owned(), |svg, (here, there)| {
        svg.replace(here, there)
    })
}

/// 2000 → 2k, 10000000 → 10M; nothing for what is not 1, 2 or 5 of a decade, as labels would
/// run into one another.
fn short(value: f64) -> String {
    let leading = value / 10_f64.powf(value.log10().floor());
    if ![1.0, 2.0, 5.0, 10.0]
        .iter()
        .any(|tick| (leading - tick).abs() < 1e-6)
    {
        return String::new();
    }
    let (scaled, unit) = match value {
        v if v >= 1e9 => (v / 1e9, "G"),
        v if v >= 1e6 => (v / 1e6, "M"),
        v if v >= 1e3 => (v / 1e3, "k"),
        v => (v, ""),
    };
    let text = format!("{scaled:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    format!("{text}{unit}")
}
