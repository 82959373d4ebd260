/** The ground of a scene, as it is drawn. */

import { BufferAttribute, BufferGeometry, Color } from 'three';
import { AIR, GRID } from './shaders';

/** Level ground and steep, by day and by night. */
const DAY = [new Color(0xcbcfbe), new Color(0xb8ab9c)] as const;
const NIGHT = [new Color(0x1a2430), new Color(0x2e2f3b)] as const;

export const uniforms = {
  uLevelled: { value: new Color() },
  uSteep: { value: new Color() },
};

export function colour(night: boolean): void {
  const [level, steep] = night ? NIGHT : DAY;
  uniforms.uLevelled.value.copy(level);
  uniforms.uSteep.value.copy(steep);
}

export const vertex = /* glsl */ `
precision highp float;
in vec3 position, normal;
uniform mat4 viewMatrix, projectionMatrix;
out vec3 vAt, vNormal;
void main() {
  vAt = position;
  vNormal = normal;
  gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
}`;

/** In the sun, and in the shade of something. */
export const lit = fragment(false);
export const shaded = fragment(true);

function fragment(shade: boolean): string {
  return /* glsl */ `${AIR}${GRID}
uniform vec3 uSunLight, uAbove, uBelow, uLevelled, uSteep;
uniform float uShadow;
in vec3 vAt, vNormal;
out vec4 colour;
void main() {
  vec3 n = normalize(vNormal);
  vec3 light = mix(uBelow, uAbove, 0.5 + 0.5 * n.z) + uSunLight * max(dot(n, uSun), 0.0);
  // Against that on level ground, which keeps its colour.
  float lit = dot(light, vec3(1.0)) / dot(uAbove + uSunLight * uSun.z, vec3(1.0));
  float steep = clamp((1.0 - n.z - 0.02) / 0.16, 0.0, 1.0);
  // The grid and the rings of the plane, on the colours of this ground.
  vec3 c = ground(vAt) - uGround + mix(uLevelled, uSteep, steep);
  c *= 0.15 + 0.85 * lit * lit;${shade ? /* glsl */ `
  // What the sun does not reach loses nothing.
  c *= mix(1.0, uShadow, clamp(dot(n, uSun) / uSun.z, 0.0, 1.0));` : ''}
  vec4 a = air(vAt);
  colour = vec4(mix(c, a.rgb, a.a), 1.0);
}`;
}

/** Triangles of the ground as a geometry. */
export function geometry(positions: Float32Array, normals: Float32Array, triangles: Uint32Array): BufferGeometry {
  const made = new BufferGeometry();
  made.setAttribute('position', new BufferAttribute(positions, 3));
  made.setAttribute('normal', new BufferAttribute(normals, 3));
  made.setIndex(new BufferAttribute(triangles, 1));
  return made;
}
