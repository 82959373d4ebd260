use std::collections::BTreeMap;
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::desk::Desk;

fn number(value: &Value, key: &str) -> f64 {
    value[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} of {value}"))
}

#[test]
fn far_dist_states_counts_and_their_growth() {
    let desk = Desk::new();
    let report = desk.json("experiment far-dist --largest 4000 --json --out results/here");
    let scenes = report["scenes"].as_array().unwrap();
    let objects: Vec<f64> = scenes.iter().map(|s| number(s, "objects")).collect();
    assert_eq!(objects, [23_951.0, 4_000.0]);
    for scene in scenes {
        let rows = scene["rows"].as_array().unwrap();
        let dists: Vec<f64> = rows.iter().map(|r| number(r, "far_dist_m")).collect();
        assert_eq!(dists, [200.0, 300.0, 450.0, 675.0, 1000.0, 1500.0]);
        assert_eq!(rows[0]["ratio"], Value::Null);
        let mut ratios = Vec::new();
        for pair in rows.windows(2) {
            let ratio = number(&pair[1], "count") / number(&pair[0], "count");
            assert_eq!(number(&pair[1], "ratio"), ratio);
            assert!(ratio >= 1.0, "more is drawn with a larger far_dist");
            ratios.push(ratio);
        }
        let mean = ratios.iter().sum::<f64>() / 5.0;
        assert!((number(scene, "mean_ratio") - mean).abs() < 1e-9);
        assert!(number(scene, "exponent") > 0.0);
        assert!(number(scene, "node_size_m") >= 0.0);
        assert!(number(scene, "r2") <= 1.0);
    }
    assert!(report["circumstances"]["seed"].is_u64());

    let read = |name: &str| std::fs::read_to_string(desk.path("results/here").join(name)).unwrap();
    assert_eq!(
        serde_json::from_str::<Value>(&read("far-dist.json")).unwrap(),
        report
    );
    assert!(read("far-dist.svg").starts_with("<svg"));
    let csv = read("far-dist.csv");
    assert!(
        csv.starts_with("city,objects,far_dist_m,count,ratio"),
        "{csv}"
    );
    assert_eq!(csv.lines().count(), 1 + 2 * 6);
}

#[test]
fn scaling_states_each_cost() {
    let desk = Desk::new();
    let report = desk.json("experiment scaling --largest 10000 --json");
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 1);
    for key in [
        "objects",
        "build_s",
        "open_ms",
        "bytes",
        "visible",
        "retrieve_us",
        "copy_us",
        "rstar_us",
        "linear_us",
    ] {
        assert!(number(&rows[0], key) > 0.0, "{key}");
    }
    assert_eq!(number(&rows[0], "objects"), 10_000.0);
}

#[test]
fn culling_states_what_each_method_keeps_and_costs() {
    let desk = Desk::new();
    desk.out("generate --objects 900 --seed 5 -o own.citylod");
    let report = desk.json("experiment culling --city own.citylod --json");
    let rows = report["rows"].as_array().unwrap();
    let of = |row: &Value, key: &str| row[key].as_str().unwrap().to_owned();
    assert_eq!(of(&rows[0], "city"), "own");
    for row in rows {
        assert!(number(row, "ns_per_box") > 0.0, "{row}");
        let lost = number(row, "false_negatives");
        let method = of(row, "method");
        if !method.contains("without slack") && !method.contains("spheres") {
            assert_eq!(lost, 0.0, "{row}");
        }
        let needless = number(row, "false_positive_pct");
        if method.contains("axes") || method.contains("exact") {
            assert_eq!(needless, 0.0, "{row}");
        }
        if method == "f64 planes" && of(row, "boxes") == "random at borders" {
            assert!(needless > 0.0, "planes keep more than meets: {row}");
        }
    }
}

#[test]
fn a_city_of_ones_own_is_measured_too() {
    let desk = Desk::new();
    desk.out("generate --objects 700 --seed 5 -o own.citylod");
    let text = desk.out("experiment far-dist --largest 1000 --city own.citylod");
    assert!(text.contains("own (700 objects)"), "{text}");
    let run = desk.run("experiment far-dist --largest 1000 --city none.citylod");
    assert_eq!(run.code, Some(1));
    assert!(run.err.contains("none.citylod: cannot open"), "{}", run.err);
}

#[test]
fn views_come_with_counts_and_pictures() {
    let desk = Desk::new();
    desk.out("generate --objects 3000 --seed 5 -o own.citylod");
    let report = desk.json("experiment views --city own.citylod --json --out seen");
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2 * 3 * 2);
    for pair in rows.chunks(2) {
        let [all, some] = pair else {
            panic!("rows come in pairs");
        };
        assert_eq!(all["view"], some["view"]);
        assert_eq!([&all["lod"], &some["lod"]], [false, true]);
        let (all, fewer) = (number(all, "count"), number(some, "count"));
        assert!(fewer > 0.0 && fewer <= all);
        // Near, all is within the finest level's range; elsewhere it is not.
        assert_eq!(fewer == all, some["view"] == "near", "{some}");
    }
    let png = |name: &str| std::fs::read(desk.path("seen").join(name)).unwrap();
    for city in ["generated", "own"] {
        let picture = |view: &str, what: &str| png(&format!("views-{city}-{view}-{what}.png"));
        for view in ["level", "far", "near"] {
            let [all, some, levels] =
                ["without-lod", "with-lod", "levels"].map(|what| picture(view, what));
            assert!(all.starts_with(b"\x89PNG\r\n\x1a\n"));
            assert_eq!(all == some, view == "near");
            assert_ne!(some, levels);
        }
    }
    assert!(!desk.path("seen/views.svg").exists());
    let csv = std::fs::read_to_string(desk.path("seen/views.csv")).unwrap();
    assert!(csv.starts_with("city,view,lod,count"), "{csv}");
}

/// Rows of one scene, view and number of objects asked for, by strategy.
fn by_strategy(rows: &[Value]) -> Vec<BTreeMap<&str, &Value>> {
    let key = |row: &'_ Value| {
        let text = |name: &str| row[name].as_str().unwrap().to_owned();
        (text("scene"), text("view"), row["asked"].as_u64())
    };
    rows.chunk_by(|a, b| key(a) == key(b))
        .map(|rows| {
            let named = rows
                .iter()
                .map(|row| (row["strategy"].as_str().unwrap(), row));
            named.collect()
        })
        .collect()
}

#[test]
fn accuracy_keeps_its_laws_in_every_row() {
    let desk = Desk::new();
    desk.out("generate --objects 1200 --seed 5 -o own.citylod");
    let report =
        desk.json("experiment accuracy --largest 3000 --city own.citylod --json --out here");
    let rows = report["rows"].as_array().unwrap();
    for row in rows {
        let value = |key| number(row, key);
        assert!(value("parameter") > 0.0, "{row}");
        assert!(value("retrieve_us") > 0.0, "{row}");
        assert!(
            value("worst_missed_px") <= value("largest_omitted_px"),
            "{row}"
        );
        assert!(value("largest_omitted_px") <= value("bound_px"), "{row}");
        assert!(value("coverage_err_pct") <= value("missed_px_pct"), "{row}");
        assert!(value("missed_px_pct") <= 100.0, "{row}");
        assert!(
            value("far_districts_kept") <= value("far_districts"),
            "{row}"
        );
    }
    assert_eq!(number(&report, "bound_violations"), 0.0);
    let groups = by_strategy(rows);
    // Fewer than scenes times views times counts: small cities have too few objects for some.
    assert!(groups.len() > 40, "{}", groups.len());
    equal_counts_are_compared(&groups);
    for pair in groups.windows(2) {
        let [fewer, more] = [pair[0]["budget"], pair[1]["budget"]];
        if fewer["view"] == more["view"] && fewer["scene"] == more["scene"] {
            let missed = [fewer, more].map(|row| number(row, "missed_px_pct"));
            assert!(missed[0] >= missed[1], "more objects miss less: {missed:?}");
        }
    }
    let missing = |row: &&Value| number(row, "missed_px_pct") > 0.0;
    assert!(
        rows.iter().filter(missing).count() > 100,
        "something is missed"
    );

    for costs in report["cost"]
        .as_array()
        .unwrap()
        .chunks(3)
        .collect::<Vec<_>>()
        .windows(2)
    {
        for (more, less) in costs[0].iter().zip(costs[1]) {
            assert_eq!(more["strategy"], less["strategy"]);
            if more["scene"] == less["scene"] {
                assert!(number(more, "missed_px_pct") > number(less, "missed_px_pct"));
                if more["strategy"] == "error" {
                    assert!(
                        number(more, "count") <= number(less, "count"),
                        "{more} {less}"
                    );
                }
            }
        }
    }
    for speed in report["speed"].as_array().unwrap() {
        for key in [
            "error_us",
            "moving_error_us",
            "moving_budget_us",
            "first_error_us",
            "first_budget_us",
            "linear_us",
            "linear_over_error",
            "views",
        ] {
            assert!(number(speed, key) > 0.0, "{key} of {speed}");
        }
    }
    for file in [
        "accuracy.csv",
        "accuracy-cost.csv",
        "accuracy-speed.csv",
        "accuracy-time.svg",
    ] {
        assert!(desk.path("here").join(file).is_file(), "{file}");
    }
}

fn equal_counts_are_compared(groups: &[BTreeMap<&str, &Value>]) {
    let mut compared = 0;
    for group in groups {
        let value = |strategy: &str, key| number(group[strategy], key);
        let asked = value("budget", "asked");
        assert_eq!(value("budget", "count"), asked);
        assert_eq!(value("random", "count"), asked);
        // The same objects, unless sizes tie.
        assert!(value("error", "count") >= asked);
        assert_eq!(value("error", "count"), value("oracle", "count"));
        assert_eq!(
            value("error", "missed_px_pct"),
            value("oracle", "missed_px_pct")
        );
        if value("error", "count") == asked {
            assert_eq!(
                value("error", "missed_px_pct"),
                value("budget", "missed_px_pct")
            );
        }
        // Nobody leaves out less of the largest with as many objects.
        let best = value("budget", "largest_omitted_px");
        for (strategy, row) in group {
            if number(row, "count") <= asked {
                assert!(
                    best <= number(row, "largest_omitted_px"),
                    "{strategy}: {row}"
                );
                compared += 1;
            }
            if number(row, "largest_omitted_px") == 0.0 {
                assert_eq!(number(row, "missed_px_pct"), 0.0, "all is drawn: {row}");
            }
        }
    }
    assert!(compared > 200, "{compared}");
}

/// Starts all experiments, waits until the page says `word`, kills them, and gives the page.
fn interrupted(desk: &Desk, words: &str, word: &str) -> String {
    let mut command = desk.command();
    let words = format!("experiment all --largest 3000 --out report {words}");
    command.args(words.split_whitespace());
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let start = Instant::now();
    let page = loop {
        let page = std::fs::read_to_string(desk.path("report/index.html")).unwrap_or_default();
        if page.contains(word) {
            break page;
        }
        assert!(start.elapsed() < Duration::from_secs(120), "{page}");
        std::thread::sleep(Duration::from_millis(5));
    };
    child.kill().unwrap();
    let lines = String::from_utf8(child.wait_with_output().unwrap().stderr).unwrap();
    assert!(lines.starts_with("[1/"), "a line a step: {lines}");
    page
}

#[test]
fn an_interrupted_run_leaves_what_was_found() {
    let desk = Desk::new();
    let page = interrupted(&desk, "", "far-dist.csv");
    assert!(page.ends_with("</html>\n"), "whole");
    let chapter = |name: &str| {
        let start = page.find(&format!("<section id=\"{name}\">")).unwrap();
        let end = page[start..].find("</section>").unwrap();
        page[start..start + end].to_owned()
    };
    let done = chapter("far-dist");
    for part in [
        "<svg",
        "<table>",
        "23951",
        "citylod experiment far-dist --out report --largest 3000",
    ] {
        assert!(done.contains(part), "{part} in {done}");
    }
    for name in ["scaling", "accuracy"] {
        let waiting = chapter(name);
        assert!(
            waiting.contains("Not run yet") && !waiting.contains("<table>"),
            "{waiting}"
        );
    }
    assert!(page.contains("1 of "), "it says how much there is");
    for link in ["http://", "https://", "src=\"//"] {
        let outside = page
            .replace("http://www.w3.org/2000/svg", "")
            .contains(link);
        assert!(!outside, "nothing is fetched: {link}");
    }
    for file in ["far-dist.csv", "far-dist.json", "far-dist.svg"] {
        assert!(desk.path("report").join(file).is_file(), "{file}");
    }
}

#[test]
fn an_experiment_that_fails_is_named_and_the_others_are_run() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("report")).unwrap();
    let page = interrupted(&desk, "--city none.citylod", "scaling.csv");
    assert!(page.contains("Failed: none.citylod: cannot open"), "{page}");
}

#[test]
fn the_controller_keeps_what_others_do_not() {
    let desk = Desk::new();
    let report = desk.json("experiment controller --json --out results");
    let rows = report["rows"].as_array().unwrap();
    let of = |name: &'static str| {
        rows.iter()
            .filter(move |row| row["controller"] == name)
            .cloned()
    };
    assert!(rows.iter().all(|row| row["scenario"].is_string()));
    for row in of("citylod") {
        assert_eq!(row["seeds_held"], row["seeds"], "{row}");
        assert_eq!(row["limit_cycle"], false, "{row}");
        assert!(number(&row, "overshoot_pct") <= 10.0, "{row}");
        assert!(number(&row, "rms_pct") <= 10.0, "{row}");
    }
    for other in ["factor 1.02", "classes"] {
        let fails = |row: &Value| row["seeds_held"] != row["seeds"];
        assert!(of(other).any(|row| fails(&row)), "{other}");
    }
    let flight = |at: usize| number(&report["flight"][at], "median_off_pct");
    assert!(flight(0) < 10.0 && flight(0) < flight(1) && flight(0) < flight(2));
    let read = |name: &str| std::fs::read_to_string(desk.path("results").join(name)).unwrap();
    for plot in [
        "controller.svg",
        "controller-start-far-below.svg",
        "controller-spike.svg",
    ] {
        assert!(read(plot).contains("far_dist, m"), "{plot}");
        assert_eq!(read(plot).matches("</svg>").count(), 1, "{plot}");
    }
}
