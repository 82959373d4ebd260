use std::borrow::Cow;

use serde::Deserialize;
use serde_json::value::RawValue;

use crate::geom::DVec3;
use crate::import::json::{Arrays, Token, pointer};

/// A geometry of a city object or a template, its boundaries still text.
#[derive(Deserialize)]
pub(super) struct Geometry<'a> {
    #[serde(rename = "type", borrow)]
    pub(super) kind: Cow<'a, str>,
    #[serde(borrow)]
    pub(super) lod: Option<&'a RawValue>,
    #[serde(borrow)]
    pub(super) boundaries: Option<&'a RawValue>,
    pub(super) template: Option<usize>,
    #[serde(rename = "transformationMatrix")]
    pub(super) matrix: Option<Box<[f64; 16]>>,
}

pub(super) const INSTANCE: &str = "GeometryInstance";

/// How many arrays are nested around the vertex indices.
pub(super) fn depth_of(kind: &str) -> Option<usize> {
    match kind {
        "MultiPoint" => Some(POINTS),
        "MultiLineString" => Some(2),
        "MultiSurface" | "CompositeSurface" => Some(SURFACES),
        "Solid" => Some(4),
        "MultiSolid" | "CompositeSolid" => Some(5),
        _ => None,
    }
}

pub(super) const POINTS: usize = 1;
/// An array of surfaces, each an array of rings.
const SURFACES: usize = 3;

/// What was found in boundaries beside the vertices.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Boundaries {
    /// A surface of k corners and h holes takes k + 2h − 2.
    pub(super) triangles: u64,
    /// What to say of indices that name no vertex, and of anything that is no index.
    pub(super) problem: Option<String>,
}

impl Boundaries {
    /// Hands the vertices of `text` to `take`, those that come more than once more than once.
    pub(super) fn walk(
        text: &str,
        index_depth: usize,
        vertices: usize,
        mut take: impl FnMut(usize),
    ) -> Self {
        let mut found = Self::default();
        let mut depth = 0;
        let (mut corners, mut rings) = (0_u64, 0_u64);
        let mut outside = Outside::default();
        for token in Arrays::new(text) {
            match token {
                Token::Number(index) if depth == index_depth => {
                    corners += 1;
                    let at = index as usize;
                    if at as f64 == index && at < vertices {
                        take(at);
                    } else {
                        outside.note(index);
                    }
                }
                Token::Open if depth < index_depth => depth += 1,
                Token::Close => {
                    depth -= 1;
                    if depth + 1 == index_depth {
                        rings += 1;
                    }
                    if depth + 2 == index_depth {
                        if index_depth >= SURFACES && rings > 0 {
                            found.triangles += (corners + 2 * (rings - 1)).saturating_sub(2);
                        }
                        (corners, rings) = (0, 0);
                    }
                }
                Token::Open | Token::Number(_) | Token::Other => {
                    found.problem = Some(format!(
                        "its boundaries are not {index_depth} arrays nested around vertex indices; what comes behind is left out"
                    ));
                    return found;
                }
            }
        }
        found.problem = outside.problem(vertices);
        found
    }
}

#[derive(Default)]
struct Outside {
    count: u64,
    first: f64,
}

impl Outside {
    #[cold]
    fn note(&mut self, index: f64) {
        if self.count == 0 {
            self.first = index;
        }
        self.count += 1;
    }

    fn problem(&self, vertices: usize) -> Option<String> {
        (self.count > 0).then(|| {
            format!(
                "{} of its vertex indices out of range, the first {}, with {vertices} vertices; left out",
                self.count, self.first
            )
        })
    }
}

/// Reads an array of `[x, y, z]` into `points`, which is cleared. A number too large for an f64
/// becomes infinite.
pub(super) fn points(
    text: Option<&RawValue>,
    member: &str,
    points: &mut Vec<DVec3>,
) -> Result<(), (String, String)> {
    const POINT_DEPTH: usize = 2;
    points.clear();
    let Some(text) = text else { return Ok(()) };
    let mut depth = 0;
    let mut point = [0.0; 3];
    let mut numbers = 0;
    for token in Arrays::new(text.get()) {
        match token {
            Token::Number(value) if depth == POINT_DEPTH && numbers < 3 => {
                point[numbers] = value;
                numbers += 1;
            }
            Token::Open if depth < POINT_DEPTH => {
                depth += 1;
                numbers = 0;
            }
            Token::Close if depth < POINT_DEPTH => return Ok(()),
            Token::Close if numbers == 3 => {
                depth -= 1;
                points.push(DVec3::from_array(point));
            }
            _ if depth == 0 => return Err((member.to_owned(), "is no array".into())),
            _ => {
                let place = pointer(member, points.len());
                return Err((place, "expected three numbers in an array".into()));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_by_corners_and_holes() {
        for (text, kind, triangles) in [
            ("[[[0,1,2]]]", "MultiSurface", 1),
            ("[[[0,1,2,3]],[[0,1,2]]]", "CompositeSurface", 3),
            ("[[[0,1,2,3],[4,5,6,7]]]", "MultiSurface", 8),
            ("[[[[0,1,2]],[[0,1,3]],[[1,2,3]],[[0,2,3]]]]", "Solid", 4),
            ("[[[[[0,1,2]]]],[[[[0,1,2]]]]]", "MultiSolid", 2),
            ("[0,1,2]", "MultiPoint", 0),
            ("[[0,1,2]]", "MultiLineString", 0),
            ("[[[0,1]],[[]],[]]", "MultiSurface", 0),
            ("[]", "Solid", 0),
        ] {
            let depth = depth_of(kind).unwrap_or_default();
            let found = Boundaries::walk(text, depth, 8, |_| {});
            let expected = Boundaries {
                triangles,
                problem: None,
            };
            assert_eq!(found, expected, "{kind} {text}");
        }
    }

    #[test]
    fn what_is_no_index_is_named() {
        for (text, taken, says) in [
            (
                "[[[0,1,8]]]",
                2,
                "1 of its vertex indices out of range, the first 8,",
            ),
            (
                "[[[0,-1,0.5]]]",
                1,
                "2 of its vertex indices out of range, the first -1,",
            ),
            ("[[[0,1,1e999]]]", 2, "the first inf"),
            ("[[[0,1,null]]]", 2, "not 3 arrays"),
            ("[[0,1]]", 0, "not 3 arrays"),
            ("[[[[0]]]]", 0, "not 3 arrays"),
            ("{}", 0, "not 3 arrays"),
        ] {
            let mut count = 0;
            let found = Boundaries::walk(text, SURFACES, 8, |_| count += 1);
            assert_eq!(count, taken, "{text}");
            let problem = found.problem.unwrap_or_default();
            assert!(problem.contains(says), "{text}: {problem}");
        }
    }
}
