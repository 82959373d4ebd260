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
