use serde_json::Value;

use crate::desk::Desk;

/// Rows of an experiment over about 4,000 posts.
fn rows(name: &str) -> Vec<Value> {
    let desk = Desk::new();
    let report = desk.json(&format!(
        "experiment {name} --largest 4300 --json --out here"
    ));
    for extension in ["csv", "json"] {
        let file = desk.path("here").join(format!("{name}.{extension}"));
        assert!(file.is_file(), "{}", file.display());
    }
    report["rows"].as_array().unwrap().clone()
}

fn number(row: &Value, key: &str) -> f64 {
    row[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} of {row}"))
}

#[test]
fn criteria_are_compared_within_what_they_certify() {
    let rows = rows("terrain-criteria");
    for criterion in ["roughness", "error", "motion", "vertex"] {
        let of: Vec<&Value> = rows
            .iter()
            .filter(|r| r["criterion"] == criterion)
            .collect();
        assert!(of.len() > 5);
        let counts = of
            .windows(2)
            .map(|pair| [0, 1].map(|n| number(pair[n], "triangles")));
        for [less, more] in counts {
            assert!(
                less <= more,
                "{criterion}: a larger share draws {more} after {less}"
            );
        }
        for row in of {
            // Infinite where the eye is too near for a bound.
            let certified = row["error_px"].as_f64().unwrap_or(f64::INFINITY);
            assert!(
                number(row, "measured_px") <= certified * (1.0 + 1e-12),
                "{row}"
            );
            assert!(number(row, "select_us") > 0.0);
        }
    }
}

#[test]
fn every_way_mends_all_cracks() {
    let rows = rows("terrain-cracks");
    assert_eq!(rows.len(), 4);
    assert!(number(&rows[0], "cracks") > 0.0 && number(&rows[0], "worst_gap_m") > 0.0);
    for row in &rows[1..] {
        assert_eq!(
            (number(row, "cracks"), number(row, "worst_gap_m")),
            (0.0, 0.0)
        );
    }
    let [skip, both, subdivide] = [1, 2, 3].map(|n| number(&rows[n], "triangles"));
    assert!(skip <= both && both <= subdivide);
}

#[test]
fn interpolation_by_variance_lies_between_the_two() {
    let rows = rows("terrain-interpolation");
    let [bilinear, bicubic] = [0, 1].map(|n| number(&rows[n], "rms_m"));
    assert!(bicubic < bilinear, "the ground is smooth");
    assert_eq!(number(&rows[0], "bicubic_share"), 0.0);
    assert_eq!(number(&rows[1], "bicubic_share"), 1.0);
    for row in &rows[2..] {
        let share = number(row, "bicubic_share");
        assert!(share > 0.0 && share < 1.0);
        assert!(number(row, "rms_m") < bilinear, "{row}");
    }
}

#[test]
fn threads_refine_to_the_same_cut() {
    for row in rows("terrain-parallel") {
        assert_eq!(row["same"], true);
        assert!(number(&row, "splits") > 0.0);
    }
}

#[test]
fn only_c_draws_less_in_motion() {
    let rows = rows("terrain-motion");
    let of = |method: &str, tuned_to: &str| -> Vec<f64> {
        let of = rows
            .iter()
            .filter(|r| r["method"] == method && r["tuned_to"] == tuned_to);
        of.map(|row| number(row, "triangles")).collect()
    };
    for method in ["ROAM", "regular quadtree"] {
        let counts = of(method, "error");
        assert_eq!(counts[0], counts[1], "{method}");
    }
    for tuned_to in ["count", "error"] {
        let counts = of("C", tuned_to);
        assert!(counts.is_sorted_by(|slow, fast| slow >= fast), "{counts:?}");
        assert!(counts.last() < counts.first(), "{counts:?}");
    }
}

#[test]
fn a_store_gives_the_same_triangles_and_stays_within_its_queue() {
    let desk = Desk::new();
    let report = desk.json("experiment terrain-store --largest 70000 --json --out here");
    assert_eq!(report["rows"].as_array().unwrap().len(), 10);
    assert_eq!(report["differing_frames"], 0);
    for row in report["rows"].as_array().unwrap() {
        assert!(number(row, "triangles") > 0.0 && number(row, "triangles") % 2048.0 == 0.0);
        for way in ["files_fps", "anew_fps", "stores_fps", "queue_fps"] {
            assert!(number(row, way) > 0.0, "{way}");
        }
        let ratio = number(row, "stores_fps") / number(row, "files_fps");
        assert!((number(row, "ratio") - ratio).abs() < 1e-9 * ratio);
    }
    for row in report["memory"].as_array().unwrap() {
        assert!(number(row, "held_tiles") <= 300.0);
    }
    assert!(desk.path("here/terrain-store-memory.csv").is_file());
}
