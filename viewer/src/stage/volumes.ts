/**
 * Shadows of boxes on the ground of a scene, as volumes: what lies in the shade of a box is what
 * lies within the box swept away from the sun. Back sides of volumes that the ground hides are
 * counted up in the stencil buffer, front sides down; ground whose count is not 0 is drawn once
 * more, in the shade. Right from whatever place, within volumes too.
 *
 * Source: E. Bilas, J. Carmack, stencil shadow volumes by depth fail, 2000.
 */

import {
  BackSide,
  BufferAttribute,
  type BufferGeometry,
  DecrementWrapStencilOp,
  FrontSide,
  IncrementWrapStencilOp,
  type Material,
  NotEqualStencilFunc,
} from 'three';
import type { Vec3 } from '../api';

/** The shadow volume of a unit cube: corners, and whether each is swept away from the sun. */
export function volume(geometry: BufferGeometry, sun: Vec3): void {
  const places: number[] = [];
  const swept: number[] = [];
  const index: number[] = [];
  const quad = (corners: readonly (readonly [Vec3, number])[]) => {
    const first = swept.length;
    for (const [corner, away] of corners) {
      places.push(...corner);
      swept.push(away);
    }
    index.push(...[0, 1, 2, 0, 2, 3].map((k) => first + k));
  };
  const lit = (axis: number, side: number) => (side * 2 - 1) * sun[axis]! > 0;
  for (const axis of [0, 1, 2]) {
    for (const side of [0, 1]) {
      const face = corners(axis, side);
      const away = lit(axis, side) ? 0 : 1;
      quad(face.map((corner) => [corner, away]));
      if (away) continue;
      for (const [k, from] of face.entries()) {
        const to = face[(k + 1) % 4]!;
        // The face on the other side of this edge.
        const other = [0, 1, 2].find((a) => a !== axis && from[a] === to[a])!;
        if (!lit(other, from[other]!)) quad([[to, 0], [from, 0], [from, 1], [to, 1]]);
      }
    }
  }
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(places), 3));
  geometry.setAttribute('swept', new BufferAttribute(new Float32Array(swept), 1));
  geometry.setIndex(index);
}

/** Corners of a face of the unit cube, counterclockwise as seen from outside. */
function corners(axis: number, side: number): Vec3[] {
  const round = [[0, 0], [1, 0], [1, 1], [0, 1]];
  if (side === 0) round.reverse();
  return round.map(([u, v]) => {
    const corner: Vec3 = [0, 0, 0];
    corner[axis] = side;
    corner[(axis + 1) % 3] = u!;
    corner[(axis + 2) % 3] = v!;
    return corner;
  });
}

/** Counts the back sides of volumes up where something hides them, or the front sides down. */
export function counting(material: Material, back: boolean): void {
  material.side = back ? BackSide : FrontSide;
  material.colorWrite = false;
  material.depthWrite = false;
  material.stencilWrite = true;
  material.stencilZFail = back ? IncrementWrapStencilOp : DecrementWrapStencilOp;
}

/** Draws only where something was counted. */
export function counted(material: Material): void {
  material.depthWrite = false;
  material.stencilWrite = true;
  material.stencilFunc = NotEqualStencilFunc;
}

/**
 * The volume of a box reaches as far below the box as shadows fall on a steep slope; farther ones
 * are cut off. Not to the lowest ground: what is drawn in vain would be most of the picture.
 */
export const vertex = /* glsl */ `
precision highp float;
in vec3 position;
in float swept;
in vec4 low, high;
uniform mat4 viewMatrix, projectionMatrix;
uniform vec3 uSun;
void main() {
  vec3 at = mix(low.xyz, high.xyz, position);
  float bottom = low.z - 2.0 * (high.z - low.z) - 5.0;
  at -= uSun / uSun.z * swept * (at.z - bottom);
  gl_Position = projectionMatrix * viewMatrix * vec4(at, 1.0);
}`;

export const fragment = /* glsl */ `
precision mediump float;
out vec4 colour;
void main() { colour = vec4(0.0); }`;
