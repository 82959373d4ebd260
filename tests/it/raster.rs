use citylod::geom::{Aabb, DVec3, DepthRange, Orientation, Projection, View};
use citylod::raster::{IdBuffer, NONE, Projector};
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

use crate::support::{self, Camera, Form, Window, between, point, rng};

const SIZE: [u32; 2] = [48, 32];
/// How far snapping moves a border at most: half a step of 1/4096 pixel each way at both ends of
/// an edge; and as much again for the rounding of what is snapped.
const SNAP_PX: f64 = 2.0 / 4096.0;
/// Relative rounding of a depth, and of what goes into it.
const DEPTH_ERROR: f64 = 1e-9;

/// A ray by the camera's own axes: origin, direction of one metre of depth.
fn ray(camera: &Camera, size: [u32; 2], column: f64, row: f64) -> (DVec3, DVec3) {
    let across = column / f64::from(size[0]);
    let upward = 1.0 - row / f64::from(size[1]);
    let mix = |low: f64, high: f64, share: f64| low + (high - low) * share;
    match camera.window {
        Window::Tangents {
            left,
            right,
            bottom,
            top,
        } => {
            let (x, y) = (mix(left, right, across), mix(bottom, top, upward));
            (
                camera.eye,
                camera.forward + camera.right * x + camera.up * y,
            )
        }
        Window::Metres {
            half_width,
            half_height,
        } => {
            let x = mix(-half_width, half_width, across);
            let y = mix(-half_height, half_height, upward);
            (
                camera.eye + camera.right * x + camera.up * y,
                camera.forward,
            )
        }
    }
}

/// Depth at which a ray meets the surface of a box between near and far, slab by slab.
fn depth_of(b: &Aabb, (origin, direction): (DVec3, DVec3), near: f64, far: f64) -> Option<f64> {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let (low, high) = (b.min()[axis] - origin[axis], b.max()[axis] - origin[axis]);
        if direction[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let (a, c) = (low / direction[axis], high / direction[axis]);
        enter = enter.max(a.min(c));
        leave = leave.min(a.max(c));
    }
    let between = |t: &f64| (near..=far).contains(t);
    Some(enter)
        .filter(|_| enter <= leave)
        .filter(between)
        .or(Some(leave).filter(|_| enter <= leave).filter(between))
}

/// What may be seen through a point of the buffer: the nearest boxes, ties and near ties.
fn seen(camera: &Camera, boxes: &[Aabb], column: f64, row: f64) -> Vec<(u32, f64)> {
    let through = ray(camera, SIZE, column, row);
    let far = camera.far.unwrap_or(f64::INFINITY);
    let hits: Vec<(u32, f64)> = (0..)
        .zip(boxes)
        .filter_map(|(id, b)| Some((id, depth_of(b, through, camera.near, far)?)))
        .collect();
    let nearest = hits.iter().map(|hit| hit.1).fold(f64::INFINITY, f64::min);
    let scale = 1.0 + reach(camera) * 1e-4 / nearest.abs().max(1e-300);
    let limit = nearest + nearest.abs() * DEPTH_ERROR * scale;
    hits.into_iter().filter(|hit| hit.1 <= limit).collect()
}

/// A matrix is relative to the origin and loses what its eye is away from there.
fn reach(camera: &Camera) -> f64 {
    match camera.form {
        Form::Matrix => camera.eye.length(),
        _ => 0.0,
    }
}

fn drawn(view: &View, boxes: &[Aabb]) -> IdBuffer {
    let projector = Projector::new(view, SIZE);
    let mut buffer = IdBuffer::new(SIZE[0], SIZE[1]);
    for (id, b) in (0..).zip(boxes) {
        buffer.draw_box(&projector, b, id);
    }
    buffer
}

/// Compares every pixel with rays; returns how many pixels had to be decided by rays beside their
/// centre.
fn check(camera: &Camera, boxes: &[Aabb], what: &str) -> u32 {
    let view = camera.view();
    let projector = Projector::new(&view, SIZE);
    let buffer = drawn(&view, boxes);
    let mut beside = 0;
    for row in 0..SIZE[1] {
        for column in 0..SIZE[0] {
            let centre = [f64::from(column) + 0.5, f64::from(row) + 0.5];
            let got = buffer.id(column, row);
            let expected = seen(camera, boxes, centre[0], centre[1]);
            let depth = buffer.depth()[(row * SIZE[0] + column) as usize];
            let agrees = match got {
                None => expected.is_empty(),
                Some(id) => expected.iter().any(|hit| hit.0 == id),
            };
            if agrees {
                if let Some(hit) = expected.iter().find(|hit| Some(hit.0) == got) {
                    let metres = projector.metres(depth);
                    let error = (metres - hit.1).abs() / hit.1.abs().max(1e-300);
                    // A surface seen edge-on is no deeper than its ends, a ray's depth on it is
                    // anything.
                    let grazing = seen(camera, boxes, centre[0] + SNAP_PX, centre[1] + SNAP_PX);
                    let slope = grazing
                        .iter()
                        .find(|g| g.0 == hit.0)
                        .map_or(f64::INFINITY, |g| (g.1 - hit.1).abs() / hit.1.abs());
                    let allowed = 1e-9 + slope * 4.0 + reach(camera) * 1e-12 / hit.1.abs();
                    assert!(
                        error <= allowed,
                        "{what}: depth {metres} at {column},{row}, should be {}\n{camera:?}",
                        hit.1
                    );
                }
                continue;
            }
            beside += 1;
            let snap = SNAP_PX * (1.0 + reach(camera) * 1e-9 * f64::from(SIZE[0]) / SNAP_PX);
            let around = (0..16).map(|i| {
                let angle = f64::from(i) * std::f64::consts::TAU / 16.0;
                [
                    centre[0] + snap * angle.cos(),
                    centre[1] + snap * angle.sin(),
                ]
            });
            let possible: Vec<_> = around
                .map(|[x, y]| seen(camera, boxes, x, y))
                .chain([expected])
                .collect();
            let explained = match got {
                None => possible.iter().any(Vec::is_empty),
                Some(id) => possible.iter().flatten().any(|hit| hit.0 == id),
            };
            assert!(
                explained,
                "{what}: {got:?} at {column},{row}, rays see {possible:?}\n{camera:?}\n{:?}",
                got.map(|id| boxes[id as usize])
            );
        }
    }
    beside
}

#[test]
fn every_pixel_shows_what_a_ray_through_its_centre_meets() {
    let mut rng = rng(41);
    let (mut pixels, mut beside) = (0, 0);
    for case in 0..400 {
        let scene = support::scene(&mut rng);
        let boxes: Vec<Aabb> = scene.objects.iter().map(|o| o.bounds).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
        let camera = Camera::random(&mut rng, &bounds);
        beside += check(&camera, &boxes, &format!("case {case}"));
        pixels += SIZE[0] * SIZE[1];
    }
    println!("{beside} of {pixels} pixels decided beside their centre");
    assert!(beside * 500 < pixels, "{beside} of {pixels}");
}

fn look(eye: DVec3, forward: DVec3, fov_y_deg: f64, near: f64, far: Option<f64>) -> Camera {
    let forward = forward.normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let viewport = [1536, 1024];
    let top = (fov_y_deg.to_radians() / 2.0).tan();
    let side = top * 1.5;
    Camera {
        eye,
        right,
        up,
        forward,
        window: Window::Tangents {
            left: -side,
            right: side,
            bottom: -top,
            top,
        },
        near,
        far,
        viewport,
        form: Form::LookAt {
            target: eye + forward * eye.length().max(1.0),
            fov_y_deg,
        },
    }
}

fn cuboid(middle: DVec3, half: DVec3) -> Aabb {
    Aabb::new(middle - half, middle + half).unwrap()
}

#[test]
fn hard_cases_agree_with_rays() {
    let mut rng = rng(7);
    let forward = DVec3::new(0.6, 0.8, -0.05);
    for fov in [0.01, 60.0, 120.0, 179.9] {
        for near in [1e-6, 0.1] {
            for far in [None, Some(500.0)] {
                for offset in [DVec3::ZERO, DVec3::new(6.4e6, -3.1e6, 4.9e6)] {
                    let eye = offset + DVec3::new(1.5, -2.25, 3.0);
                    let camera = look(eye, forward, fov, near, far);
                    let ahead = |d: f64| eye + camera.forward * d;
                    let one = DVec3::ONE;
                    let mut cases = vec![
                        ("around the eye", cuboid(eye, one * 5.0)),
                        ("eye on a face", cuboid(eye + DVec3::X * 2.0, one * 2.0)),
                        (
                            "eye on an edge",
                            cuboid(eye + DVec3::new(2.0, 2.0, 0.0), one * 2.0),
                        ),
                        ("eye on a corner", cuboid(eye + one * 2.0, one * 2.0)),
                        ("behind", cuboid(ahead(-20.0), one)),
                        ("beside", cuboid(eye + camera.right * 9.0, one * 8.0)),
                        ("ahead", cuboid(ahead(20.0), one)),
                        ("small ahead", cuboid(ahead(400.0), one * 0.01)),
                        (
                            "flat below",
                            cuboid(eye - DVec3::Z, DVec3::new(900.0, 900.0, 0.0)),
                        ),
                        (
                            "flat ahead",
                            cuboid(ahead(30.0), DVec3::new(10.0, 0.0, 10.0)),
                        ),
                        ("line", cuboid(ahead(30.0), DVec3::new(0.0, 0.0, 10.0))),
                        ("point", cuboid(ahead(30.0), DVec3::ZERO)),
                        (
                            "huge below",
                            cuboid(eye - DVec3::Z * 1e9, one * (1e9 - 2.0)),
                        ),
                        ("huge around", cuboid(eye, one * 1e9)),
                        ("cut by far", cuboid(ahead(500.0), one * 30.0)),
                        ("cut by near", cuboid(ahead(near), one * near * 0.7)),
                        (
                            "thin wall",
                            cuboid(ahead(3.0), DVec3::new(0.001, 50.0, 50.0)),
                        ),
                    ];
                    for (name, b) in &cases {
                        check(&camera, &[*b], &format!("{name}, fov {fov}, near {near}"));
                    }
                    cases.shuffle(&mut rng);
                    let boxes: Vec<Aabb> = cases.iter().map(|case| case.1).collect();
                    check(
                        &camera,
                        &boxes,
                        &format!("together, fov {fov}, near {near}"),
                    );
                }
            }
        }
    }
}

#[test]
fn the_order_of_drawing_does_not_matter() {
    let mut rng = rng(5);
    for _ in 0..100 {
        let scene = support::scene(&mut rng);
        let mut boxes: Vec<(u32, Aabb)> =
            (0..).zip(scene.objects.iter().map(|o| o.bounds)).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(&b.1));
        let view = Camera::random(&mut rng, &bounds).view();
        let projector = Projector::new(&view, SIZE);
        let mut pictures = [0, 1].map(|_| {
            boxes.shuffle(&mut rng);
            let mut buffer = IdBuffer::new(SIZE[0], SIZE[1]);
            for (id, b) in &boxes {
                buffer.draw_box(&projector, b, *id);
            }
            buffer
        });
        assert_eq!(pictures[0].ids(), pictures[1].ids());
        assert_eq!(pictures[0].depth(), pictures[1].depth());
        pictures[0].clear();
        assert!(pictures[0].ids().iter().all(|&id| id == NONE));
        assert!(pictures[0].visible_pixels().is_empty());
    }
}

/// A sheet of triangles across and beyond the window, its inner vertices anywhere in their cell.
fn sheet(
    rng: &mut Pcg64Mcg,
    cells: u32,
    most: f64,
    at: &dyn Fn(f64, f64) -> DVec3,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let side = cells + 1;
    let mut vertices = Vec::new();
    for j in 0..side {
        for i in 0..side {
            let inner = i > 0 && i < cells && j > 0 && j < cells;
            let mut shake = || {
                if inner {
                    between(rng, -most, most)
                } else {
                    0.0
                }
            };
            let (x, y) = (f64::from(i) + shake(), f64::from(j) + shake());
            vertices.push(at(x / f64::from(cells), y / f64::from(cells)));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..cells {
        for i in 0..cells {
            let a = j * side + i;
            let (b, c, d) = (a + 1, a + side, a + side + 1);
            triangles.extend([[a, b, d], [d, c, a]]);
        }
    }
    (vertices, triangles)
}

/// How often each pixel is covered when triangles are drawn one by one.
fn coverage(projector: &Projector, vertices: &[DVec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut counts = vec![0; (SIZE[0] * SIZE[1]) as usize];
    let mut buffer = IdBuffer::new(SIZE[0], SIZE[1]);
    for triangle in triangles {
        buffer.clear();
        buffer.draw_mesh(projector, vertices, &[*triangle], 1);
        for (count, &id) in counts.iter_mut().zip(buffer.ids()) {
            *count += u32::from(id == 1);
        }
    }
    counts
}

#[test]
fn triangles_that_share_edges_cover_each_pixel_once() {
    let mut rng = rng(19);
    for case in 0..60 {
        let eye = DVec3::new(3.0, -4.0, 2.0);
        let camera = look(eye, DVec3::Y, 60.0, 0.1, None);
        let projector = Projector::new(&camera.view(), SIZE);
        // Some run exactly along pixel centres and borders: 80 cells are 60 × 40 pixels.
        let exact = case % 20 == 0;
        let cells = if exact { 80 } else { 7 };
        let shake = if exact { 0.0 } else { 0.24 };
        let tilt = if exact {
            0.0
        } else {
            between(&mut rng, -0.5, 0.5)
        };
        let depth = 40.0;
        let (w, h) = (
            depth * 0.577_350_269_189_625_7 * 1.5,
            depth * 0.577_350_269_189_625_7,
        );
        let at = |x: f64, y: f64| {
            let (x, y) = ((2.0 * x - 1.0) * 1.25, (2.0 * y - 1.0) * 1.25);
            let depth = depth * (1.0 + tilt * x * 0.5);
            eye + DVec3::new(x * w * depth / 40.0, depth, y * h * depth / 40.0)
        };
        let (vertices, triangles) = sheet(&mut rng, cells, shake, &at);
        let counts = coverage(&projector, &vertices, &triangles);
        let wrong = counts.iter().filter(|&&count| count != 1).count();
        assert_eq!(wrong, 0, "case {case}");
    }
}

#[test]
fn ground_that_reaches_behind_the_eye_has_no_hole() {
    let mut rng = rng(23);
    let (mut all, mut twice) = (0, 0);
    for _ in 0..40 {
        let eye = DVec3::new(6.4e6, 100.0, between(&mut rng, 0.01, 30.0));
        let camera = look(eye, DVec3::new(0.3, 1.0, -0.2), 75.0, 0.05, None);
        let projector = Projector::new(&camera.view(), SIZE);
        let reach = 1e5;
        let (vertices, triangles) = sheet(&mut rng, 8, 0.24, &|x, y| {
            DVec3::new(6.4e6 + (x - 0.5) * reach, 100.0 + (y - 0.5) * reach, 0.0)
        });
        let counts = coverage(&projector, &vertices, &triangles);
        for (pixel, &count) in counts.iter().enumerate() {
            let (column, row) = (pixel as u32 % SIZE[0], pixel as u32 / SIZE[0]);
            let (_, direction) = ray(&camera, SIZE, f64::from(column) + 0.5, f64::from(row) + 0.5);
            let meets = eye + direction * (eye.z / -direction.z);
            let on_it = direction.z < 0.0
                && (meets - DVec3::new(6.4e6, 100.0, 0.0)).abs().max_element() < reach * 0.49;
            if on_it {
                assert!(count >= 1, "a hole at {column},{row}");
                all += 1;
                twice += u32::from(count > 1);
            }
        }
    }
    assert!(all > 10_000 && twice * 1000 < all, "{twice} of {all}");
}

#[test]
fn a_box_stays_within_the_bounds_of_its_projection() {
    let mut rng = rng(3);
    let mut drawn_pixels = 0;
    for _ in 0..3000 {
        let camera = look(
            point(&mut rng, -50.0, 50.0),
            point(&mut rng, -1.0, 1.0),
            70.0,
            0.1,
            None,
        );
        let b = cuboid(
            camera.eye
                + camera.forward * between(&mut rng, 10.0, 200.0)
                + point(&mut rng, -8.0, 8.0),
            point(&mut rng, 0.0, 6.0),
        );
        let buffer = drawn(&camera.view(), &[b]);
        let Window::Tangents { right, top, .. } = camera.window else {
            unreachable!("made of tangents");
        };
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut ahead = true;
        for i in 0..8 {
            let pick = |axis: usize| {
                if i >> axis & 1 == 1 {
                    b.max()[axis]
                } else {
                    b.min()[axis]
                }
            };
            let p = DVec3::new(pick(0), pick(1), pick(2)) - camera.eye;
            let depth = p.dot(camera.forward);
            ahead &= depth > camera.near;
            let place = [
                (0.5 + p.dot(camera.right) / (2.0 * depth * right)) * f64::from(SIZE[0]),
                (0.5 - p.dot(camera.up) / (2.0 * depth * top)) * f64::from(SIZE[1]),
            ];
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        if !ahead {
            continue;
        }
        for (pixel, _) in buffer.ids().iter().enumerate().filter(|(_, id)| **id == 0) {
            drawn_pixels += 1;
            let centre =
                [pixel as u32 % SIZE[0], pixel as u32 / SIZE[0]].map(|c| f64::from(c) + 0.5);
            for axis in 0..2 {
                let within = low[axis] - SNAP_PX..=high[axis] + SNAP_PX;
                assert!(
                    within.contains(&centre[axis]),
                    "{centre:?} outside {within:?}"
                );
            }
        }
    }
    assert!(drawn_pixels > 10_000, "{drawn_pixels}");
}

#[test]
fn a_box_and_its_triangles_give_one_picture() {
    const TRIANGLES: [[u32; 3]; 12] = [
        [0, 2, 6],
        [6, 4, 0],
        [1, 3, 7],
        [7, 5, 1],
        [0, 1, 5],
        [5, 4, 0],
        [2, 3, 7],
        [7, 6, 2],
        [0, 1, 3],
        [3, 2, 0],
        [4, 5, 7],
        [7, 6, 4],
    ];
    let mut rng = rng(29);
    for _ in 0..400 {
        let b = cuboid(point(&mut rng, -20.0, 20.0), point(&mut rng, 0.5, 12.0));
        let camera = Camera::random(&mut rng, &b);
        if matches!(camera.form, Form::Matrix) || b.distance(camera.eye) < camera.near * 2.0 {
            continue;
        }
        let view = camera.view();
        let projector = Projector::new(&view, SIZE);
        let whole = drawn(&view, &[b]);
        let corners: Vec<DVec3> = (0..8)
            .map(|i| {
                let pick = |axis: usize| {
                    if i >> axis & 1 == 1 {
                        b.max()[axis]
                    } else {
                        b.min()[axis]
                    }
                };
                DVec3::new(pick(0), pick(1), pick(2))
            })
            .collect();
        let mut mesh = IdBuffer::new(SIZE[0], SIZE[1]);
        mesh.draw_mesh(&projector, &corners, &TRIANGLES, 0);
        let differ = whole
            .ids()
            .iter()
            .zip(mesh.ids())
            .filter(|(a, b)| a != b)
            .count();
        assert!(differ <= 1, "{differ} pixels differ\n{camera:?}\n{b:?}");
    }
}

#[test]
fn pixels_are_counted_by_id() {
    let camera = look(DVec3::ZERO, DVec3::Y, 60.0, 0.1, None);
    let projector = Projector::new(&camera.view(), SIZE);
    let mut buffer = IdBuffer::new(SIZE[0], SIZE[1]);
    let wall = |y: f64, half: f64| cuboid(DVec3::new(0.0, y, 0.0), DVec3::new(half, 0.5, half));
    buffer.draw_box(&projector, &wall(100.0, 1e4), 9);
    buffer.draw_box(&projector, &wall(50.0, 10.0), 4);
    buffer.draw_box(&projector, &wall(50.0, 10.0), 6); // the same place: the lower id stays
    let pixels = buffer.visible_pixels();
    assert_eq!(pixels.iter().map(|p| p.0).collect::<Vec<_>>(), [4, 9]);
    assert_eq!(pixels.iter().map(|p| p.1).sum::<u32>(), SIZE[0] * SIZE[1]);
    for (id, count) in pixels {
        let found = buffer.ids().iter().filter(|&&i| i == id).count();
        assert_eq!(found as u32, count);
    }
    assert_eq!(buffer.id(SIZE[0] / 2, SIZE[1] / 2), Some(4));
    assert_eq!(buffer.id(SIZE[0], 0), None);
}

#[test]
fn damaged_meshes_and_empty_buffers_draw_nothing() {
    let camera = look(DVec3::ZERO, DVec3::Y, 60.0, 0.1, None);
    let projector = Projector::new(&camera.view(), SIZE);
    let mut buffer = IdBuffer::new(SIZE[0], SIZE[1]);
    let p = |x: f64, z: f64| DVec3::new(x, 10.0, z);
    let vertices = [
        p(-5.0, -5.0),
        p(5.0, -5.0),
        p(0.0, 5.0),
        p(f64::NAN, 0.0),
        p(0.0, f64::INFINITY),
    ];
    buffer.draw_mesh(
        &projector,
        &vertices,
        &[[0, 1, 9], [0, 1, 3], [0, 1, 4], [0, 1, 1]],
        3,
    );
    assert!(buffer.visible_pixels().is_empty());
    buffer.draw_mesh(&projector, &vertices, &[[0, 1, 2]], 3);
    assert_eq!(buffer.visible_pixels().len(), 1);
    buffer.draw_box(&projector, &Aabb::EMPTY, 1);
    let largest = DVec3::splat(f64::MAX / 4.0);
    buffer.draw_box(&projector, &Aabb::new(-largest, largest).unwrap(), 5);
    assert!(
        buffer
            .visible_pixels()
            .iter()
            .all(|&(id, _)| id == 3 || id == 5)
    );
    for size in [[0, 0], [0, 5], [7, 0]] {
        let projector = Projector::new(&camera.view(), size);
        let mut nothing = IdBuffer::new(size[0], size[1]);
        nothing.draw_box(&projector, &cuboid(DVec3::Y * 9.0, DVec3::ONE), 0);
        assert!(nothing.ids().is_empty());
    }
}

#[test]
fn a_view_of_any_projection_fills_the_whole_buffer() {
    let far_wall = cuboid(DVec3::Y * 50.0, DVec3::new(1e4, 1.0, 1e4));
    for projection in [
        Projection::Perspective { fov_y_deg: 45.0 },
        Projection::Orthographic { height_m: 30.0 },
        Projection::OffAxis {
            left: 0.2,
            right: 0.5,
            bottom: -0.3,
            top: -0.1,
        },
    ] {
        let view = View::new(
            DVec3::ZERO,
            Orientation::LookAt {
                target: DVec3::Y,
                up: DVec3::Z,
            },
            projection,
            DepthRange::default(),
            [1920, 1080],
        )
        .unwrap();
        let buffer = drawn(&view, &[far_wall]);
        assert!(buffer.ids().iter().all(|&id| id == 0));
    }
}

#[test]
fn left_and_upper_borders_count_right_and_lower_ones_do_not() {
    let orientation = Orientation::LookAt {
        target: DVec3::Y,
        up: DVec3::Z,
    };
    let depth = DepthRange {
        near: 0.0,
        far: None,
    };
    let height_m = f64::from(SIZE[1]); // a metre is a pixel
    let projection = Projection::Orthographic { height_m };
    let view = View::new(DVec3::ZERO, orientation, projection, depth, SIZE).unwrap();
    let projector = Projector::new(&view, SIZE);
    let corners = [[0.5, 0.5], [10.5, 0.5], [10.5, 10.5], [0.5, 10.5]]
        .map(|[x, y]| DVec3::new(x - 24.0, 5.0, 16.0 - y));
    // Both triangles have corners on centres and a diagonal through centres.
    for (triangle, left_of_diagonal) in [([0, 1, 2], false), ([0, 2, 3], true)] {
        let mut buffer = IdBuffer::new(SIZE[0], SIZE[1]);
        buffer.draw_mesh(&projector, &corners, &[triangle], 0);
        for row in 0..SIZE[1] {
            for column in 0..SIZE[0] {
                let square = column < 10 && row < 10;
                let covered = square && (column < row) == left_of_diagonal;
                assert_eq!(buffer.id(column, row).is_some(), covered, "{column},{row}");
            }
        }
    }
}
