/** What the graphics card runs. All lengths are metres, relative to the scene's origin, z up. */

/**
 * Sky and air, shared by everything: what is far away takes the colour of the sky behind it.
 * Colours are mixed as they are shown, in sRGB, and curves are ratios, not powers: a processor that
 * stands in for a graphics card draws this too.
 */
export const AIR = /* glsl */ `
precision highp float;
uniform vec3 uEye, uSun, uZenith, uHorizon, uGlow;
uniform float uAir;
vec3 sky(vec3 way) {
  float up = max(way.z, 0.0);
  float height = up * (3.4 + up) / (1.0 + up * (3.4 + up));
  float s = max(dot(way, uSun), 0.0);
  float s4 = s * s * s * s, s16 = s4 * s4 * s4 * s4;
  return mix(mix(uHorizon, uZenith, height), uGlow, 0.5 * s16 * s4 + 0.22 * s4 * (1.0 - up));
}
// The colour of the air and, in the last place, how much of it there is.
vec4 air(vec3 from) {
  vec3 way = from - uEye;
  float a = length(way) * uAir;
  way.z = max(way.z, 0.0);
  return vec4(sky(normalize(way + vec3(0.0, 0.0, 1e-4))), a * a / (1.0 + a * a));
}
`;

/** The ground's own colour: a grid of 100 m and 1 km, a faint one of 10 m, and rings where levels end. */
export const GRID = /* glsl */ `
uniform vec3 uGround, uLine, uRing, uRingEye;
uniform float uRings[8], uRingShow;
float lines(vec2 p, float step_) {
  vec2 q = p / step_;
  vec2 w = fwidth(q);
  vec2 d = abs(fract(q - 0.5) - 0.5) / max(w, 1e-6);
  float fine = 1.0 - smoothstep(0.1, 0.45, max(w.x, w.y));
  return (1.0 - min(min(d.x, d.y), 1.0)) * fine;
}
vec3 ground(vec3 p) {
  vec3 colour = mix(uGround, uLine, max(max(0.2 * lines(p.xy, 10.0), 0.5 * lines(p.xy, 100.0)), 0.9 * lines(p.xy, 1000.0)));
  if (uRingShow > 0.0) {
    float far = length(p - uRingEye);
    float w = max(fwidth(far), 1e-4);
    for (int k = 0; k < 8; k++) {
      float d = abs(far - uRings[k]);
      colour = mix(colour, uRing, uRingShow * (1.0 - smoothstep(0.9, 2.0, d / w)));
    }
  }
  return colour;
}
`;

export const skyVertex = /* glsl */ `
precision highp float;
in vec3 position;
uniform mat4 uBack;
out vec3 vWay;
void main() {
  vec4 way = uBack * vec4(position.xy, 1.0, 1.0);
  vWay = way.xyz / way.w;
  gl_Position = vec4(position.xy, 1.0, 1.0);
}`;

export const skyFragment = /* glsl */ `${AIR}
in vec3 vWay;
out vec4 colour;
void main() { colour = vec4(sky(normalize(vWay)), 1.0); }`;

export const planeVertex = /* glsl */ `
precision highp float;
in vec3 position;
uniform mat4 viewMatrix, projectionMatrix;
uniform vec3 uEye;
uniform float uLevel, uReach;
out vec3 vAt;
void main() {
  vAt = vec3(uEye.xy + position.xy * uReach, uLevel);
  gl_Position = projectionMatrix * viewMatrix * vec4(vAt, 1.0);
}`;

export const planeFragment = /* glsl */ `${AIR}${GRID}
in vec3 vAt;
out vec4 colour;
void main() {
  vec4 a = air(vAt);
  colour = vec4(mix(ground(vAt), a.rgb, a.a), 1.0);
}`;

/** Boxes cast along the sun onto the ground. Opaque: where shadows overlap they are one. */
export const shadowVertex = /* glsl */ `${AIR}
in vec3 position;
in vec4 low, high;
uniform mat4 viewMatrix, projectionMatrix;
uniform vec3 uGround;
uniform float uLevel, uShadow;
out vec3 vColour;
void main() {
  vec3 at = mix(low.xyz, high.xyz, position);
  float above = max(at.z - uLevel, 0.0);
  at = vec3(at.xy - uSun.xy / uSun.z * above, uLevel);
  vec4 a = air(at);
  vColour = mix(uGround * uShadow, a.rgb, a.a);
  gl_Position = projectionMatrix * viewMatrix * vec4(at, 1.0);
}`;

export const shadowFragment = /* glsl */ `
precision highp float;
in vec3 vColour;
out vec4 colour;
void main() { colour = vec4(vColour, 1.0); }`;

export const boxVertex = /* glsl */ `${AIR}
in vec3 position, normal;
in vec4 low, high;
uniform mat4 viewMatrix, projectionMatrix;
uniform vec3 uSunLight, uAbove, uBelow, uPickColour;
uniform vec3 uKinds[64], uLevels[8], uHeights[6];
uniform float uTint, uPick;
out vec3 vColour;
out vec4 vAir;
out vec2 vPlace;
flat out vec2 vSize;
flat out float vWall;
vec3 kind() {
  int key = int(high.w + 0.5);
  if (uTint < 0.5) return uKinds[key % 64];
  if (uTint < 1.5) return uLevels[min(key / 64, 7)];
  // Heights double from colour to colour: 5, 10, 20, 40, 80, 160 m.
  float h = clamp(log2(max(high.z - low.z, 1.0) / 5.0), 0.0, 5.0);
  int at = min(int(h), 4);
  return mix(uHeights[at], uHeights[at + 1], h - float(at));
}
void main() {
  vec3 at = mix(low.xyz, high.xyz, position);
  vec3 size = high.xyz - low.xyz;
  vec3 inside = position * size;
  vec3 axis = abs(normal);
  vWall = 1.0 - axis.z;
  vPlace = axis.z > 0.5 ? inside.xy : axis.x > 0.5 ? inside.yz : inside.xz;
  vSize = axis.z > 0.5 ? size.xy : axis.x > 0.5 ? size.yz : size.xz;
  vec3 light = mix(uBelow, uAbove, 0.5 + 0.5 * normal.z) + uSunLight * max(dot(normal, uSun), 0.0);
  // No two neighbours quite alike.
  float own = fract(low.w * 0.6180339887);
  vColour = kind() * light * (0.94 + 0.1 * own);
  if (low.w == uPick) vColour = uPickColour * (0.55 + 0.5 * light);
  vAir = air(at);
  gl_Position = projectionMatrix * viewMatrix * vec4(at, 1.0);
}`;

export const boxFragment = /* glsl */ `
precision highp float;
uniform vec3 uEdge;
uniform float uEdgeShow, uStoreys;
in vec3 vColour;
in vec4 vAir;
in vec2 vPlace;
flat in vec2 vSize;
flat in float vWall;
out vec4 colour;
void main() {
  vec3 c = vColour;
  vec2 w = max(fwidth(vPlace), 1e-5);
  // Streets are narrow: little light reaches the foot of a wall.
  c *= 1.0 - vWall * 0.3 / (1.0 + 0.2 * max(vPlace.y, 0.0));
  float storey = abs(fract(vPlace.y / 3.4) - 0.5) * 3.4;
  float near = 1.0 - smoothstep(0.15, 0.7, w.y);
  c *= 1.0 - uStoreys * vWall * near * step(6.0, vSize.y) * (1.0 - smoothstep(0.25, 0.25 + 1.5 * w.y, storey));
  vec2 d = min(vPlace, vSize - vPlace) / w;
  vec2 wide = smoothstep(3.0, 10.0, vSize / w);
  float edge = (1.0 - smoothstep(0.4, 1.4, min(d.x, d.y))) * min(wide.x, wide.y);
  c = mix(c, uEdge, uEdgeShow * edge);
  colour = vec4(mix(c, vAir.rgb, vAir.a), 1.0);
}`;

/** Lines and faces of one colour, through the air. */
export const plainVertex = /* glsl */ `
precision highp float;
in vec3 position;
uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
void main() { gl_Position = projectionMatrix * viewMatrix * modelMatrix * vec4(position, 1.0); }`;

export const plainFragment = /* glsl */ `
precision highp float;
uniform vec4 uColour;
out vec4 colour;
void main() { colour = uColour; }`;
