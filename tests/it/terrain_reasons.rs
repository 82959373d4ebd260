use crate::desk::Desk;
use crate::elevation_files::picture;

/// A desk with a city of one building, 10 m wide around 20, 20.
fn desk() -> Desk {
    let desk = Desk::new();
    desk.write("c.obj", b"o a\nv 15 15 0\nv 25 15 0\nv 25 25 9\nf 1 2 3\n");
    desk.out("import c.obj -o city.citylod");
    desk
}

/// Four columns of posts 10 m apart from (5, 5) on, these heights in each of four rows.
fn posts(row: &str) -> String {
    let head = "ncols 4 nrows 4 xllcenter 5 yllcenter 5 cellsize 10 nodata_value -9999\n";
    head.to_owned() + &format!("{row}\n").repeat(4)
}

#[test]
fn ground_without_heights_under_the_city_is_told_from_ground_elsewhere() {
    let desk = desk();
    for (name, row, expected) in [
        (
            "none.asc",
            "-9999 -9999 -9999 -9999",
            "has no height anywhere: all its posts, from 5 5 to 35 35, are no data",
        ),
        (
            "hole.asc",
            "-9999 -9999 -9999 7",
            "has no height under the city: of its posts, from 5 5 to 35 35, those there are no data",
        ),
    ] {
        desk.write(name, posts(row).as_bytes());
        let import = format!("import {name} --into city.citylod");
        desk.refuses(
            &import,
            1,
            &[name, expected, "city.terrain is left as it was"],
        );
        assert!(!desk.run(&import).err.contains("under nothing"));
    }
    let far = posts("1 2 3 4").replace("xllcenter 5", "xllcenter 500");
    desk.write("far.asc", far.as_bytes());
    desk.refuses(
        "import far.asc --into city.citylod",
        1,
        &["lies under nothing of the city"],
    );
    desk.write("whole.asc", posts("1 2 3 4").as_bytes());
    desk.out("import whole.asc --into city.citylod");
}

#[test]
fn metres_that_are_said_to_be_degrees_are_refused_with_the_way_out() {
    let desk = desk();
    let far = posts("1 2 3 4").replace("center 5", "center 500000");
    desk.write("m.asc", far.as_bytes());
    let fine = far.replace("cellsize 10", "cellsize 0.5");
    desk.write("fine.asc", fine.as_bytes());
    desk.refuses(
        "import fine.asc --into city.citylod --crs EPSG:4326",
        1,
        &[
            "fine.asc: is said to lie in EPSG:4326, whose coordinates are degrees",
            "500000 500000 to 500001.5 500001.5",
        ],
    );
    for crs in ["EPSG:4326", "OGC:CRS84", "EPSG:4258"] {
        desk.refuses(
            &format!("import m.asc --into city.citylod --crs {crs}"),
            1,
            &[
                "m.asc: is said to lie in",
                crs,
                "500000 500000 to 500030 500030",
                "no longitudes and latitudes",
                "EPSG:25832",
            ],
        );
    }
    // One of few systems in their range of codes that have metres.
    let run = desk.run("import m.asc --into city.citylod --crs EPSG:4647");
    assert!(run.err.contains("lies under nothing"), "{}", run.err);
}

#[test]
fn a_system_that_nobody_knows_is_not_taken_for_degrees() {
    let desk = desk();
    let degrees = posts("1 2 3 4").replace("cellsize 10", "cellsize 0.001");
    desk.write("d.asc", degrees.as_bytes());
    for crs in ["EPSG:99999", "ESRI:102003"] {
        desk.refuses(
            &format!("import d.asc --into city.citylod --crs {crs}"),
            1,
            &["d.asc", crs, "is not known to have any", "EPSG:4326"],
        );
    }
}

#[test]
fn packed_elevation_is_refused_with_what_unpacks_it() {
    let desk = desk();
    for (name, way_out) in [
        ("N40W106.hgt.gz", "gunzip N40W106.hgt.gz"),
        ("dem.tif.GZ", "gunzip dem.tif.GZ"),
        ("N40W106.SRTMGL1.hgt.zip", "unzip N40W106.SRTMGL1.hgt.zip"),
    ] {
        desk.write(name, b"\x1f\x8b");
        desk.refuses(
            &format!("import {name} --into city.citylod"),
            1,
            &["is packed", way_out],
        );
    }
    for name in ["town.geojson.gz", "town.city.json.GZ"] {
        desk.write(name, b"\x1f\x8b");
        desk.refuses(
            &format!("import {name} --into city.citylod"),
            1,
            &[name, "cities are imported with -o"],
        );
    }
}

#[test]
fn options_of_png_are_told_of_where_they_are_not_used() {
    let desk = desk();
    desk.write("g.asc", posts("1 2 3 4").as_bytes());
    let told = |options: &str| {
        let run = desk.run(&format!("import g.asc --into city.citylod{options}"));
        assert_eq!(run.code, Some(0), "{}", run.err);
        let told = run.err.lines().filter(|line| line.contains("is for PNG"));
        told.map(ToOwned::to_owned).collect::<Vec<_>>()
    };
    assert!(told("").is_empty());
    let bounds = told(" --bounds 0,0,40,40");
    assert_eq!(bounds.len(), 1);
    assert!(
        bounds[0].contains("g.asc: --bounds is for PNG"),
        "{}",
        bounds[0]
    );
    assert_eq!(told(" --bounds 0,0,40,40 --encoding terrarium").len(), 2);
    desk.write("g.PNG", &picture(2, 2, &[128, 9, 0].repeat(4)));
    let run = desk.run("import g.PNG --into city.citylod --bounds 0,0,40,40 --encoding terrarium");
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(!run.err.contains("is for PNG"), "{}", run.err);
}
