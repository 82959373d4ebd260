use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use citylod::geom::{Aabb, DVec3, DepthRange, Orientation, Projection, View};
use citylod::raster::{LEVEL_COLOURS, Picture, Solid, paint};

use crate::desk::Desk;

const SIZE: [u32; 2] = [160, 90];

fn view(eye: DVec3, target: DVec3) -> View {
    let up = DVec3::Z;
    let depth = DepthRange::default();
    View::new(
        eye,
        Orientation::LookAt { target, up },
        Projection::Perspective { fov_y_deg: 60.0 },
        depth,
        SIZE,
    )
    .unwrap()
}

fn building(middle: DVec3, half: f64, height: f64) -> Solid {
    let foot = DVec3::new(half, half, 0.0);
    let bounds = Aabb::new(middle - foot, middle + foot.with_z(height)).unwrap();
    Solid::by_class(bounds, "Building", "b")
}

fn pixel(picture: &Picture, column: u32, row: u32) -> [u8; 3] {
    let at = (row * picture.size[0] + column) as usize * 3;
    [0, 1, 2].map(|channel| picture.rgb[at + channel])
}

fn brightness(rgb: [u8; 3]) -> u32 {
    rgb.into_iter().map(u32::from).sum()
}

#[test]
fn sky_is_above_ground_and_blue() {
    let picture = paint(
        &view(DVec3::Z * 50.0, DVec3::new(0.0, 100.0, 50.0)),
        SIZE,
        &[],
        0.0,
    );
    let (above, below) = (pixel(&picture, 80, 2), pixel(&picture, 80, 87));
    assert!(above[2] > above[0] + 20, "{above:?}");
    assert!(below[2] < below[0], "{below:?}");
    assert_eq!(picture.rgb.len(), (SIZE[0] * SIZE[1] * 3) as usize);
}

#[test]
fn a_tower_is_seen_and_throws_a_shadow() {
    let view = view(DVec3::new(0.0, -300.0, 250.0), DVec3::ZERO);
    let bare = paint(&view, SIZE, &[], 0.0);
    let tower = building(DVec3::ZERO, 10.0, 80.0);
    let painted = paint(&view, SIZE, &[tower], 0.0);
    assert_eq!(painted, paint(&view, SIZE, &[tower], 0.0));
    let darker = |column: u32, row: u32| {
        let [here, before] = [&painted, &bare].map(|p| brightness(pixel(p, column, row)));
        here * 5 < before * 4
    };
    let count = |columns: std::ops::Range<u32>| {
        let pixels = columns.flat_map(|c| (0..SIZE[1]).map(move |r| (c, r)));
        pixels.filter(|&(c, r)| darker(c, r)).count()
    };
    // The sun stands to the left.
    assert_eq!(count(0..70), 0);
    assert!(count(88..160) > 10, "{}", count(88..160));
}

#[test]
fn a_box_around_the_eye_does_not_hide_the_city() {
    let eye = DVec3::new(0.0, -60.0, 5.0);
    let view = view(eye, DVec3::ZERO);
    let tower = building(DVec3::ZERO, 10.0, 80.0);
    let around = building(eye.with_z(0.0), 40.0, 30.0);
    let bare = paint(&view, SIZE, &[tower], 0.0);
    assert_eq!(bare, paint(&view, SIZE, &[tower, around], 0.0));
}

#[test]
fn levels_have_colours_of_their_own() {
    let view = view(DVec3::new(0.0, -100.0, 30.0), DVec3::ZERO);
    let bounds = Aabb::new(DVec3::new(-20.0, -20.0, 0.0), DVec3::new(20.0, 20.0, 60.0)).unwrap();
    let middles: Vec<[u8; 3]> = (0..7)
        .map(|level| {
            let picture = paint(
                &view,
                SIZE,
                &[Solid::by_level(bounds, "Bridge", level)],
                0.0,
            );
            pixel(&picture, 80, 45)
        })
        .collect();
    for (i, a) in middles.iter().enumerate() {
        for b in &middles[..i] {
            let apart: u32 = (0..3).map(|c| u32::from(a[c].abs_diff(b[c]))).sum();
            assert!(apart > 40, "{middles:?}");
        }
    }
}

#[test]
fn empty_pictures_and_parallel_views_are_painted() {
    let upright = view(DVec3::Z * 50.0, DVec3::Y * 100.0);
    assert!(paint(&upright, [0, 9], &[], 0.0).rgb.is_empty());
    let depth = DepthRange {
        near: 0.0,
        far: None,
    };
    let map = View::new(
        DVec3::Z * 500.0,
        Orientation::LookAt {
            target: DVec3::ZERO,
            up: DVec3::Y,
        },
        Projection::Orthographic { height_m: 200.0 },
        depth,
        SIZE,
    )
    .unwrap();
    let picture = paint(&map, SIZE, &[building(DVec3::ZERO, 30.0, 20.0)], 0.0);
    assert_ne!(pixel(&picture, 80, 45), pixel(&picture, 10, 10));
}

/// Width, height and bytes of a picture in a file.
fn read(path: &Path) -> (u32, u32, Vec<u8>) {
    let decoder = png::Decoder::new(BufReader::new(File::open(path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(frame.color_type, png::ColorType::Rgb);
    (frame.width, frame.height, bytes)
}

const CAMERA: &str = "--eye 0,-900,260 --target 0,200,20 --size 200x120";

#[test]
fn render_writes_the_picture_that_was_asked_for() {
    let desk = Desk::new();
    desk.out("generate --objects 3000 -o city.citylod");
    let shoot = |flags: &str, name: &str| {
        let run = desk.run(format!("render city.citylod {CAMERA} -o {name} {flags}").trim_end());
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert!(
            run.err.contains(name) && run.err.contains("of 3,000 objects"),
            "{}",
            run.err
        );
        read(&desk.path(name))
    };
    let plain = shoot("", "plain.png");
    assert_eq!((plain.0, plain.1), (200, 120));
    assert_eq!(shoot("", "again.png"), plain);
    for (flags, name) in [
        ("--far-dist inf", "all.png"),
        ("--tint level", "levels.png"),
        ("--fov 30", "tele.png"),
        ("--far-dist 100 --levels 1 --beyond hide", "bare.png"),
    ] {
        assert_ne!(shoot(flags, name).2, plain.2, "{flags}");
    }
}

#[test]
fn colours_of_levels_have_a_legend() {
    let desk = Desk::new();
    desk.out("generate --objects 3000 -o city.citylod");
    let run = desk.run(&format!(
        "render city.citylod {CAMERA} -o levels.png --tint level"
    ));
    assert_eq!(run.code, Some(0), "{}", run.err);
    let mut lines = run.err.lines();
    let drawn: u32 = lines
        .next()
        .unwrap()
        .split(' ')
        .nth(1)
        .unwrap()
        .parse()
        .unwrap();
    let mut counted = 0;
    let mut levels = Vec::new();
    for line in lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        let ["level", level, name, hex, count] = words[..] else {
            panic!("{line}");
        };
        levels.push(level.parse::<usize>().unwrap());
        let (known, colour) = LEVEL_COLOURS[levels[levels.len() - 1]];
        assert_eq!((name, hex), (known, &*format!("#{colour:06x}")));
        counted += count.replace(',', "").parse::<u32>().unwrap();
    }
    assert!(
        levels.len() > 1 && levels.is_sorted_by(|a, b| a > b),
        "{levels:?}"
    );
    assert_eq!(counted, drawn);
    let plain = desk.run(&format!("render city.citylod {CAMERA} -o plain.png"));
    assert!(!plain.err.contains("level"), "{}", plain.err);
}

#[test]
fn render_refuses_what_it_cannot_draw() {
    let desk = Desk::new();
    desk.out("generate --objects 100 -o city.citylod");
    for (flags, code, says) in [
        ("-o view.jpg", 2, ".png"),
        ("-o view.png --size 9000x10", 2, "--size"),
        ("-o view.png --size 0x10", 2, "--size"),
        ("-o view.png --fov 180", 2, "--fov"),
        ("-o view.png --dist-factor 0.5", 2, "--dist-factor"),
        ("-o nowhere/view.png", 1, "nowhere/view.png: cannot write"),
    ] {
        let run = desk.run(&format!(
            "render city.citylod --eye 0,-900,260 --target 0,200,20 {flags}"
        ));
        assert_eq!(run.code, Some(code), "{flags}: {}", run.err);
        assert!(run.err.contains(says), "{flags}: {}", run.err);
        assert!(!desk.path("view.png").exists());
    }
}
