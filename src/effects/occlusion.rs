//! Occlusion: what is hidden behind nearer objects is not drawn.
//!
//! All selected objects are drawn as boxes into an id-buffer; who covers too few pixels goes. A
//! box covers at least what its object covers, so an object may be hidden by the corners of a box
//! that its mesh does not fill: buildings askew to the axes hide somewhat more than they would.
//! Objects around the eye hide nothing and stay. Where the frame draws ground, that
//! hides too, unless triangles ran out and it is coarser than declared.

use crate::geom::{Aabb, DVec3, View};
use crate::lod::Selection;
use crate::raster::{IdBuffer, NONE, Projector};
use crate::scene;

/// The id of the ground in the buffer: no object has so high a number.
const GROUND: u32 = NONE - 1;

/// Boxes drawn before it is asked again whether to go on: large ones take a millisecond each.
const BETWEEN_QUESTIONS: usize = 64;

/// Takes out the hidden objects. Kept and used again, it allocates little.
#[derive(Debug, Default)]
pub struct Occluder {
    buffer: Option<IdBuffer>,
    /// Objects that stay, ascending, with their pixels.
    seen: Vec<(u32, u32)>,
}

impl Occluder {
    /// Takes out of `selection` what covers fewer pixels than declared, and tells how many there
    /// were. `boxes` are those of all objects, by number: min x, y, z, max x, y, z; `ground` are the
    /// corners and triangles of the ground that is drawn, none where there is none.
    ///
    /// `goes_on` is asked now and then; where it says no, nothing is taken out: `None`.
    pub fn hide(
        &mut self,
        declared: &scene::Occlusion,
        view: &View,
        boxes: &[[f64; 6]],
        (corners, triangles): (&[DVec3], &[[u32; 3]]),
        selection: &mut Selection,
        mut goes_on: impl FnMut() -> bool,
    ) -> Option<u32> {
        let size = buffer_size(declared.width_px, view);
        let buffer = match &mut self.buffer {
            Some(buffer) if buffer.size() == size => buffer,
            other => other.insert(IdBuffer::new(size[0], size[1])),
        };
        buffer.clear();
        self.seen.clear();
        let projector = Projector::new(view, size);
        if !triangles.is_empty() {
            buffer.draw_mesh(&projector, corners, triangles, GROUND);
        }
        for (drawn, object) in selection.objects().enumerate() {
            if drawn % BETWEEN_QUESTIONS == 0 && !goes_on() {
                self.seen.clear();
                return None;
            }
            match Aabb::nth(boxes, object) {
                Some(bounds) if bounds.distance(view.eye()) > 0.0 => {
                    buffer.draw_box(&projector, &bounds, object);
                }
                Some(_) => self.seen.push((object, size[0] * size[1])),
                None => {} // only in a damaged file
            }
        }
        let pixels = buffer.visible_pixels().into_iter();
        self.seen
            .extend(pixels.filter(|&(id, px)| id != GROUND && px >= declared.min_pixels));
        self.seen.sort_unstable();
        let mut seen = self.seen.iter().map(|(object, _)| *object).peekable();
        Some(selection.retain(|object| seen.next_if_eq(&object).is_some()))
    }

    /// The objects that stayed, ascending, each with its pixels in the id-buffer: all of them for
    /// an object around the eye.
    pub fn seen(&self) -> &[(u32, u32)] {
        &self.seen
    }

    /// Width × height of the id-buffer, pixels; 0 before it was used.
    pub fn size(&self) -> [u32; 2] {
        self.buffer.as_ref().map_or([0, 0], IdBuffer::size)
    }
}

/// The declared width, and the height that keeps the shape of the view.
fn buffer_size(width_px: u32, view: &View) -> [u32; 2] {
    let [width, height] = view.viewport().map(f64::from);
    let rows = (f64::from(width_px) * height / width).round();
    let most = f64::from(*scene::Occlusion::WIDTHS_PX.end());
    [width_px, rows.clamp(1.0, most) as u32]
}
