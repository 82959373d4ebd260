//! Where each node lies: a forest, walked without recursion, placements composed in f64.

use glam::{DMat4, DQuat, DVec3};

use super::accessor::Reader;
use super::document::Node;
use crate::import::{ImportError, Up};

/// A node that is drawn and its transform into the scene.
pub(super) struct Placed {
    pub(super) node: usize,
    pub(super) transform: DMat4,
}

/// The nodes of the default scene, or of the whole file where there is none, parents first, in
/// file order.
pub(super) fn placed(reader: &Reader, up: Up) -> Result<Vec<Placed>, ImportError> {
    let nodes = &reader.document.nodes;
    let parents = parents(reader)?;
    let origin = origin(reader, up);
    let mut waiting: Vec<Placed> = roots(reader, &parents)?
        .into_iter()
        .rev()
        .map(|node| (node, origin))
        .map(|(node, transform)| Placed { node, transform })
        .collect();
    let mut placed = Vec::new();
    while let Some(next) = waiting.pop() {
        let node = &nodes[next.node];
        let transform = next.transform * local(reader, node, next.node)?;
        let children = node.children.iter().rev();
        waiting.extend(children.map(|&node| Placed { node, transform }));
        placed.push(Placed {
            node: next.node,
            transform,
        });
    }
    Ok(placed)
}

/// The turn to z up, about the centre of `CESIUM_RTC`, which is given in the turned system.
fn origin(reader: &Reader, up: Up) -> DMat4 {
    let turn = match up {
        Up::Y => DMat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ]),
        Up::Z => DMat4::IDENTITY,
    };
    match &reader.document.extensions.rtc {
        Some(rtc) => DMat4::from_translation(DVec3::from_array(rtc.center)) * turn,
        None => turn,
    }
}

/// The parent of each node. Fails where the nodes are no forest.
fn parents(reader: &Reader) -> Result<Vec<Option<usize>>, ImportError> {
    let nodes = &reader.document.nodes;
    let mut parents = vec![None; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        for (k, &child) in node.children.iter().enumerate() {
            let place = || format!("/nodes/{index}/children/{k}");
            let Some(parent) = parents.get_mut(child) else {
                let reason = format!("there is no node {child}; the file has {}", nodes.len());
                return reader.fail(place(), reason);
            };
            if let Some(first) = parent.replace(index) {
                let reason = format!("node {child} is already a child of node {first}");
                return reader.fail(place(), reason);
            }
        }
    }
    match cycle(&parents) {
        Some((parent, child)) => {
            let mut children = nodes[parent].children.iter();
            let k = children.position(|c| *c == child).unwrap_or(0);
            let place = format!("/nodes/{parent}/children/{k}");
            reader.fail(place, format!("node {child} is below itself"))
        }
        None => Ok(parents),
    }
}

/// A link (parent, child) that closes a cycle.
fn cycle(parents: &[Option<usize>]) -> Option<(usize, usize)> {
    // The walk that came by a node; a walk that meets its own trace has gone round.
    let mut walked = vec![usize::MAX; parents.len()];
    for start in 0..parents.len() {
        let mut node = start;
        while walked[node] == usize::MAX {
            walked[node] = start;
            match parents[node] {
                Some(parent) if walked[parent] == start => return closing(parents, parent),
                Some(parent) => node = parent,
                None => break,
            }
        }
    }
    None
}

/// The link to the first node, in file order, of the cycle that `on_cycle` is part of.
fn closing(parents: &[Option<usize>], on_cycle: usize) -> Option<(usize, usize)> {
    let above = |node: &usize| parents[*node].filter(|parent| *parent != on_cycle);
    let first = std::iter::successors(Some(on_cycle), above).min()?;
    Some((parents[first]?, first))
}

fn roots(reader: &Reader, parents: &[Option<usize>]) -> Result<Vec<usize>, ImportError> {
    let document = reader.document;
    let Some(default) = document.scene else {
        let all = 0..document.nodes.len();
        return Ok(all.filter(|node| parents[*node].is_none()).collect());
    };
    let Some(scene) = document.scenes.get(default) else {
        let count = document.scenes.len();
        let reason = format!("there is no scene {default}; the file has {count}");
        return reader.fail("/scene", reason);
    };
    let mut listed = vec![false; document.nodes.len()];
    for (k, &node) in scene.nodes.iter().enumerate() {
        let reason = match (listed.get(node), parents.get(node)) {
            (Some(true), _) => format!("node {node} is listed twice"),
            (_, Some(Some(parent))) => format!("node {node} is no root: node {parent} holds it"),
            (Some(false), _) => {
                listed[node] = true;
                continue;
            }
            _ => format!(
                "there is no node {node}; the file has {}",
                document.nodes.len()
            ),
        };
        return reader.fail(format!("/scenes/{default}/nodes/{k}"), reason);
    }
    Ok(scene.nodes.clone())
}

/// Transform of a node relative to its parent.
fn local(reader: &Reader, node: &Node, index: usize) -> Result<DMat4, ImportError> {
    if let Some(matrix) = &node.matrix {
        return Ok(DMat4::from_cols_array(matrix));
    }
    let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let Some(transform) = composed(
        node.translation.unwrap_or([0.0; 3]),
        rotation,
        node.scale.unwrap_or([1.0; 3]),
    ) else {
        return reader.fail(
            format!("/nodes/{index}/rotation"),
            "is not a rotation: its length is zero or beyond all bounds",
        );
    };
    Ok(transform)
}

/// T · R · S; `None` where the quaternion cannot be made one of length 1.
pub(super) fn composed(translation: [f64; 3], rotation: DQuat, scale: [f64; 3]) -> Option<DMat4> {
    let length = rotation.length();
    let unit = (length > 0.0 && length.is_finite()).then(|| rotation * (1.0 / length))?;
    Some(DMat4::from_scale_rotation_translation(
        DVec3::from_array(scale),
        unit,
        DVec3::from_array(translation),
    ))
}
