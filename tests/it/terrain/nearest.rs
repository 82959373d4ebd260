use citylod::geom::{Aabb, DVec2, DVec3};
use citylod::terrain::NearestGround;
use rand::RngExt;

use super::places::{between, field, flat, made_up, rng};

/// Against a look at every post, for boxes within the ground and far beyond it.
#[test]
fn the_nearest_known_ground_is_that_of_a_post_that_no_other_is_nearer_than() {
    let mut holes = 0;
    for seed in 0..150 {
        let mut rng = rng(seed + 70_000);
        let field = made_up(&mut rng);
        let (grid, nearest) = (field.grid(), NearestGround::of(&field));
        let posts = DVec2::new(grid.columns().into(), grid.rows().into());
        let size = grid.spacing() * posts;
        for _ in 0..10 {
            let reach = [1.0, 3.0, 100.0][rng.random_range(0..3)];
            let [x, y] = [size.x, size.y].map(|side| between(&mut rng, -reach, reach) * side);
            let min = DVec3::new(grid.origin().x + x, grid.origin().y + y, 3.0);
            let wide = size.x * between(&mut rng, 0.0, 0.1);
            let bounds = Aabb::new(min, min + DVec3::new(wide, wide / 2.0, 9.0)).unwrap();
            let apart = |column, row| {
                let (x, y) = (grid.x(column), grid.y(row));
                let dx = (bounds.min().x - x).max(x - bounds.max().x).max(0.0);
                let dy = (bounds.min().y - y).max(y - bounds.max().y).max(0.0);
                dx * dx + dy * dy
            };
            let posts = (0..grid.rows()).flat_map(|r| (0..grid.columns()).map(move |c| (c, r)));
            let known: Vec<_> = posts
                .filter(|&(column, row)| !field.height(column, row).is_nan())
                .map(|(column, row)| (apart(column, row), f64::from(field.height(column, row))))
                .collect();
            holes += u32::from(known.len() < grid.count());
            let least = known
                .iter()
                .map(|post| post.0)
                .min_by(f64::total_cmp)
                .unwrap();
            let found = nearest.height(&bounds).unwrap();
            assert!(known.contains(&(least, found)), "seed {seed}: {found}");
        }
    }
    assert!(holes > 100, "{holes}");
}

#[test]
fn ground_of_one_post_is_the_nearest_from_everywhere_and_without_a_height_none_is() {
    let bounds = Aabb::new(DVec3::splat(1e6), DVec3::splat(2e6)).unwrap();
    let known = flat([1, 1]);
    let height = NearestGround::of(&known).height(&bounds);
    assert_eq!(height, Some(f64::from(123.4_f32)));
    let unknown = field([5, 3], DVec2::ZERO, DVec2::ONE, |_, _| f32::NAN);
    assert_eq!(NearestGround::of(&unknown).height(&bounds), None);
}
