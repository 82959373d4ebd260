//! Heights at the posts of a regular grid.

use crate::geom::DVec2;

/// Where the posts of a regular grid stand.
///
/// Column 0, row 0 is the south-west post; columns run east, rows run north. At least one post
/// each way. No two posts share a coordinate they should not: [`Grid::x`] and [`Grid::y`] rise
/// strictly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    columns: u32,
    rows: u32,
    origin: DVec2,
    spacing: DVec2,
}

/// Heights at the posts of a [`Grid`], metres; NaN where nothing is known.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightField {
    grid: Grid,
    heights: Vec<f32>,
}

/// Why numbers are no height field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// No post at all, or more than a side may have.
    #[error(
        "the raster has {columns} x {rows} posts; each side must have from 1 to {}",
        Grid::MOST_POSTS
    )]
    Size {
        /// Posts from west to east.
        columns: u32,
        /// Posts from south to north.
        rows: u32,
    },
    /// The south-west post is nowhere.
    #[error("the origin must be finite, is {origin}")]
    Origin {
        /// As given.
        origin: DVec2,
    },
    /// Posts coincide, run backwards or off to infinity.
    #[error(
        "posts {spacing} apart from {origin} on do not stand apart: the spacing must be positive, \
         and large enough for 64-bit coordinates"
    )]
    Spacing {
        /// As given.
        spacing: DVec2,
        /// The south-west post.
        origin: DVec2,
    },
    /// Not one height for each post.
    #[error("{given} heights for {expected} posts")]
    Count {
        /// Heights given.
        given: usize,
        /// Columns times rows.
        expected: usize,
    },
    /// Not a height on Earth, often a mark for unknown that nobody declared.
    #[error(
        "the height at column {column}, row {row} is {height}, more than {} m from zero; write \
         NaN where none is known",
        HeightField::HIGHEST_M
    )]
    Height {
        /// From the west.
        column: u32,
        /// From the south.
        row: u32,
        /// As given.
        height: f32,
    },
}

impl Grid {
    /// Posts a side may have: coordinates of nodes stay within 32 bits.
    pub const MOST_POSTS: u32 = 1 << 30;

    /// A grid of `columns` × `rows` posts, the south-west one at `origin`, `spacing` apart (m).
    ///
    /// # Errors
    /// [`FieldError`] for an empty grid, an origin that is not finite, and posts that coincide.
    pub fn new(columns: u32, rows: u32, origin: DVec2, spacing: DVec2) -> Result<Self, FieldError> {
        let side = 1..=Self::MOST_POSTS;
        if !side.contains(&columns) || !side.contains(&rows) {
            return Err(FieldError::Size { columns, rows });
        }
        if !origin.is_finite() {
            return Err(FieldError::Origin { origin });
        }
        let grid = Self {
            columns,
            rows,
            origin: origin + DVec2::ZERO, // -0.0 becomes 0.0
            spacing,
        };
        // Steps are smallest against their coordinates at either end.
        let apart = |at: &dyn Fn(u32) -> f64, count: u32| {
            at(0) < at(1) && at(count - 1) < at(count) && at(count).is_finite()
        };
        let finite = spacing.is_finite() && spacing.cmpgt(DVec2::ZERO).all();
        if !finite || !apart(&|i| grid.x(i), columns) || !apart(&|j| grid.y(j), rows) {
            return Err(FieldError::Spacing { spacing, origin });
        }
        Ok(grid)
    }

    /// Posts from west to east.
    pub fn columns(&self) -> u32 {
        self.columns
    }

    /// Posts from south to north.
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// The south-west post, m.
    pub fn origin(&self) -> DVec2 {
        self.origin
    }

    /// From post to post, m, both positive.
    pub fn spacing(&self) -> DVec2 {
        self.spacing
    }

    /// How many posts there are.
    pub fn count(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Easting of a column, m.
    pub fn x(&self, column: u32) -> f64 {
        self.origin.x + f64::from(column) * self.spacing.x
    }

    /// Northing of a row, m.
    pub fn y(&self, row: u32) -> f64 {
        self.origin.y + f64::from(row) * self.spacing.y
    }
}

impl HeightField {
    /// Farthest that a height may be from zero, m: errors and ranges stay within 32 bits.
    pub const HIGHEST_M: f32 = 1e9;

    /// Heights row by row from the south, each row from the west.
    ///
    /// # Errors
    /// [`FieldError`] when there is not one height for each post, or one is beyond
    /// [`HeightField::HIGHEST_M`].
    pub fn new(grid: Grid, heights: Vec<f32>) -> Result<Self, FieldError> {
        if heights.len() != grid.count() {
            return Err(FieldError::Count {
                given: heights.len(),
                expected: grid.count(),
            });
        }
        if let Some(at) = heights.iter().position(|z| z.abs() > Self::HIGHEST_M) {
            return Err(FieldError::Height {
                column: (at % grid.columns as usize) as u32,
                row: (at / grid.columns as usize) as u32,
                height: heights[at],
            });
        }
        Ok(Self { grid, heights })
    }

    /// Where the posts stand.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// All heights, row by row from the south; NaN where nothing is known.
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// The height of a post, m; NaN where nothing is known. Beyond the last column or row it is
    /// that of the last one.
    pub fn height(&self, column: u32, row: u32) -> f32 {
        let column = column.min(self.grid.columns - 1) as usize;
        let row = row.min(self.grid.rows - 1) as usize;
        self.heights[row * self.grid.columns as usize + column]
    }
}
