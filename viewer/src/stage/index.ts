/** The picture: sky, ground, boxes and their shadows. Knows nothing of the service. */

import {
  Box3,
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  GLSL3,
  Matrix4,
  Mesh,
  PerspectiveCamera,
  RawShaderMaterial,
  Scene,
  Vector3,
  WebGLRenderer,
} from 'three';
import type { Vec3 } from '../api';
import { classColours, LEVELS, type Tint } from '../colours';
import type { GroundMesh } from '../ground/mesh';
import type { Bounds } from '../overview';
import { Frozen } from './frozen';
import { CLASSES, type Instances } from './instances';
import { DAY, NIGHT, SUN } from './palette';
import * as laid from './ground';
import * as shader from './shaders';
import { type Sample, software, Timing } from './timing';
import * as volumes from './volumes';

export { Instances } from './instances';

/** Where the eye is and how it is turned; x, y, z relative to the scene's origin. */
export interface Pose {
  eye: Vec3;
  /** Clockwise from north, degrees. */
  heading: number;
  /** Above the horizon, degrees. */
  pitch: number;
}

/** Full vertical angle of the view, degrees. */
const FOV_Y = 60;

/** No wider than this to the sides, degrees: beyond it, what is near the edge is drawn out of shape. */
const WIDEST = 100;

/** How far a picture of this shape opens upwards, degrees. */
function fovY(aspect: number): number {
  const half = (degrees: number) => Math.tan((degrees * Math.PI) / 360);
  return (Math.atan(Math.min(half(FOV_Y), half(WIDEST) / aspect)) * 360) / Math.PI;
}

/** Most rings drawn on the ground. */
const RINGS = 8;

export class Stage {
  /** Whether the processor draws, in want of a graphics card. */
  readonly slow: boolean;
  readonly camera = new PerspectiveCamera(FOV_Y, 1, 1, 100_000);
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly frozen = new Frozen();
  readonly timing: Timing;
  private readonly boxes: Mesh;
  /** Of boxes on the plane. */
  private readonly shadows: Mesh;
  /** A plane in want of ground, and the ground of the scene; one of them is drawn. */
  private readonly plane: Mesh;
  private readonly ground: Mesh;
  /** Of boxes on the ground: their volumes, counted, and the ground within them. */
  private readonly volumes: Mesh[];
  private readonly shade: Mesh;
  /** Meets the ground of the scene. */
  private meetGround: ((eye: Vec3, way: Vec3) => number | undefined) | undefined;
  private instances: Instances | undefined;
  /** Shared by all materials: a change is seen by all. */
  private readonly uniforms = {
    uEye: { value: new Vector3() },
    uSun: { value: new Vector3(...SUN).normalize() },
    uBack: { value: new Matrix4() },
    uAir: { value: 1e-4 },
    uLevel: { value: 0 },
    uReach: { value: 200_000 },
    uZenith: { value: new Color() },
    uHorizon: { value: new Color() },
    uGlow: { value: new Color() },
    uGround: { value: new Color() },
    uLine: { value: new Color() },
    uRing: { value: new Color() },
    uRingEye: { value: new Vector3() },
    uRings: { value: new Array<number>(RINGS).fill(0) },
    uRingShow: { value: 0 },
    uShadow: { value: 1 },
    uSunLight: { value: new Color() },
    uAbove: { value: new Color() },
    uBelow: { value: new Color() },
    uEdge: { value: new Color() },
    uEdgeShow: { value: 0.3 },
    uStoreys: { value: 0.07 },
    uPickColour: { value: new Color() },
    uPick: { value: -1 },
    uTint: { value: 0 },
    uKinds: { value: Array.from({ length: CLASSES }, () => new Color(0xe6e0d6)) },
    uLevels: { value: Array.from({ length: 8 }, (_, k) => new Color(LEVELS[k])) },
    uHeights: { value: Array.from({ length: 6 }, () => new Color()) },
    ...laid.uniforms,
  };
  private lowest = 0;
  private readonly bounds = new Box3();
  private casting = { onGround: false, onPlane: false };

  /** @throws where the browser has no WebGL 2. */
  constructor(canvas: HTMLCanvasElement, measured: (sample: Sample) => void) {
    this.slow = software();
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.slow, alpha: false, stencil: true, powerPreference: 'high-performance' });
    this.renderer.autoClear = false;
    this.timing = new Timing(this.renderer.getContext() as WebGL2RenderingContext, !this.slow, measured);
    this.camera.up.set(0, 0, 1);
    this.scene.matrixWorldAutoUpdate = false;

    const triangle = new BufferGeometry();
    triangle.setAttribute('position', new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const plain = new BufferGeometry();
    plain.setAttribute('position', new BufferAttribute(squares(this.uniforms.uReach.value), 3));
    const empty = new BufferGeometry();
    this.boxes = this.part(empty, shader.boxVertex, shader.boxFragment, 0);
    this.shadows = this.part(empty, shader.shadowVertex, shader.shadowFragment, 2);
    this.plane = this.part(plain, shader.planeVertex, shader.planeFragment, 1);
    this.ground = this.part(empty, laid.vertex, laid.lit, 1);
    this.volumes = [true, false].map((back) => {
      const part = this.part(empty, volumes.vertex, volumes.fragment, 2);
      volumes.counting(part.material as RawShaderMaterial, back);
      return part;
    });
    this.shade = this.part(empty, laid.vertex, laid.shaded, 3);
    volumes.counted(this.shade.material as RawShaderMaterial);
    this.part(triangle, shader.skyVertex, shader.skyFragment, 4);
    // What lies flat on the ground is seen, not fought with.
    for (const part of [this.ground, this.shade]) offset(part, 1);
    for (const part of [this.boxes, this.ground]) part.visible = false;
    // Shadows lie on the plane: drawn just before it, as seen by the depth buffer.
    offset(this.shadows, -1);
    (this.shadows.material as RawShaderMaterial).side = DoubleSide;
    this.scene.add(this.frozen.group);
    this.night(false);
  }

  /** Shows another scene: its boxes, its classes, and where they are. */
  show(instances: Instances, classes: readonly string[], bounds: Bounds): void {
    this.bounds.set(new Vector3(...bounds.min), new Vector3(...bounds.max));
    this.instances?.dispose();
    this.instances = instances;
    for (const part of [this.boxes, this.shadows]) part.geometry = instances.geometry;
    for (const part of this.volumes) part.geometry = instances.volumes;
    this.boxes.visible = true;
    classColours(classes).slice(0, CLASSES).forEach((hex, k) => this.uniforms.uKinds.value[k]!.set(hex));
  }

  /** Draws this ground; a plane where there is none. `meet` tells how far a way to it is. */
  lay(mesh: GroundMesh | undefined, meet?: (eye: Vec3, way: Vec3) => number | undefined): void {
    if (this.ground.visible) this.ground.geometry.dispose();
    this.ground.visible = mesh !== undefined;
    this.plane.visible = !mesh;
    this.meetGround = mesh && meet;
    if (mesh) this.ground.geometry = this.shade.geometry = laid.geometry(mesh.positions, mesh.normals, mesh.triangles);
    this.shadow();
  }

  /** Height of the plane, and of the ground under the eye, m. */
  level(height: number): void {
    this.uniforms.uLevel.value = height;
    this.lowest = height;
  }

  /** Air so clear that a scene of this extent is seen from outside, m. */
  clear(extent: number): void {
    this.uniforms.uAir.value = 1 / (2.2 * Math.max(extent, 1500));
  }

  /** Air that hides what is farther away than this, m. */
  haze(visibility: number): void {
    this.uniforms.uAir.value = 2 / visibility;
  }

  /** Whether boxes cast shadows on the ground, and on the plane in want of it. */
  cast(onGround: boolean, onPlane: boolean): void {
    this.casting = { onGround, onPlane };
    this.shadow();
  }

  private shadow(): void {
    const { onGround, onPlane } = this.casting;
    this.shadows.visible = onPlane && this.plane.visible;
    for (const part of [...this.volumes, this.shade]) part.visible = onGround && this.ground.visible;
  }

  night(on: boolean): void {
    const from = on ? NIGHT : DAY;
    const to = this.uniforms;
    to.uZenith.value.copy(from.zenith);
    to.uHorizon.value.copy(from.horizon);
    to.uGlow.value.copy(from.glow);
    to.uGround.value.copy(from.ground);
    to.uLine.value.copy(from.line);
    to.uRing.value.copy(from.ring);
    to.uShadow.value = from.shadow;
    to.uSunLight.value.copy(from.sun);
    to.uAbove.value.copy(from.above);
    to.uBelow.value.copy(from.below);
    to.uEdge.value.copy(from.edge);
    to.uEdgeShow.value = on ? 0.16 : 0.34;
    to.uPickColour.value.copy(from.pick);
    from.heights.forEach((colour, k) => to.uHeights.value[k]!.copy(colour));
    this.frozen.colour(from.ring);
    laid.colour(on);
  }

  tint(tint: Tint): void {
    this.uniforms.uTint.value = { class: 0, level: 1, height: 2 }[tint];
    this.uniforms.uStoreys.value = tint === 'class' ? 0.07 : 0.04;
  }

  /** Marks an object. */
  pick(object: number | undefined): void {
    this.uniforms.uPick.value = object ?? -1;
  }

  /** Draws circles about an eye on the ground; none without radii, m. */
  rings(eye: Vec3, radii: readonly number[]): void {
    const { uRings, uRingEye, uRingShow } = this.uniforms;
    uRingShow.value = radii.length > 0 ? 0.85 : 0;
    uRingEye.value.set(...eye);
    for (let k = 0; k < RINGS; k += 1) uRings.value[k] = radii[k] ?? 0;
  }

  /** Shows what the present camera sees, from wherever it goes next; as far as `reach` metres. */
  freeze(reach: number): void {
    this.frozen.show(this.camera, reach);
  }

  thaw(): void {
    this.frozen.hide();
  }

  /** Pixels of the picture for a window of this size, CSS pixels. */
  resize(width: number, height: number, ratio: number): void {
    this.renderer.setPixelRatio(this.slow ? 1 : ratio);
    this.renderer.setSize(width, height, false);
    const { camera } = this;
    camera.aspect = width / height;
    camera.fov = fovY(camera.aspect);
  }

  /** Width and height of the picture, pixels. */
  get viewport(): [number, number] {
    const { width, height } = this.renderer.domElement;
    return [width, height];
  }

  /** How far the picture opens upwards, degrees. */
  get fov(): number {
    return this.camera.fov;
  }

  /** Half the height and half the width of the picture, at a distance of 1. */
  get opening(): { high: number; wide: number } {
    const high = Math.tan((this.camera.fov * Math.PI) / 360);
    return { high, wide: high * this.camera.aspect };
  }

  /** How the camera is turned: x, y, z, w. */
  get turn(): [number, number, number, number] {
    return this.camera.quaternion.toArray() as [number, number, number, number];
  }

  place(pose: Pose): void {
    const { camera, uniforms } = this;
    camera.position.set(...pose.eye);
    const [x, y, z] = forward(pose);
    camera.lookAt(pose.eye[0] + x, pose.eye[1] + y, pose.eye[2] + z);
    [camera.near, camera.far] = this.depths();
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    uniforms.uEye.value.copy(camera.position);
    // Only directions: what is far from the origin would not fit f32.
    const turned = new Matrix4().extractRotation(camera.matrixWorld);
    uniforms.uBack.value.copy(turned).multiply(camera.projectionMatrixInverse);
  }

  /** Nearest and farthest that is drawn, m: the whole city from wherever, and nothing before the eye cut off. */
  private depths(): [near: number, far: number] {
    const { position } = this.camera;
    const above = Math.max(position.z - this.lowest, 0);
    const outside = this.bounds.distanceToPoint(position);
    const near = Math.min(Math.max(above * 0.02, 0.4), 20);
    const { min, max } = this.bounds;
    const farthest = Math.hypot(...([0, 1, 2] as const).map((k) => {
      const at = position.getComponent(k);
      return Math.max(Math.abs(at - min.getComponent(k)), Math.abs(at - max.getComponent(k)));
    }));
    return [Math.max(near, Math.min(0.3 * outside, 0.4 * above)), Math.max(100_000, 1.2 * farthest)];
  }

  /** Draws a frame. `far_dist_m` is what it is drawn with, to be told with its time. */
  draw(far_dist_m: number | undefined): void {
    this.timing.draw();
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    this.timing.end(far_dist_m);
  }

  /** What a point of the picture shows (-1 to 1, y up): an object or the ground, and how far. */
  meet(x: number, y: number): { object: number | undefined; along: number; way: Vec3 } | undefined {
    const { position } = this.camera;
    const way = new Vector3(x, y, 0.5).unproject(this.camera).sub(position).normalize();
    const hit = this.instances?.meet(position.toArray(), way.toArray());
    const down = (this.lowest - position.z) / way.z;
    const level = down > 0 ? down : Infinity;
    const ground = this.meetGround ? (this.meetGround(position.toArray(), way.toArray()) ?? Infinity) : level;
    const along = Math.min(hit?.along ?? Infinity, ground);
    if (!Number.isFinite(along)) return undefined;
    const object = hit && hit.along <= ground ? this.instances?.object(hit.slot) : undefined;
    return { object, along, way: way.toArray() };
  }

  private part(geometry: BufferGeometry, vertexShader: string, fragmentShader: string, order: number): Mesh {
    const material = new RawShaderMaterial({ glslVersion: GLSL3, vertexShader, fragmentShader, uniforms: this.uniforms });
    const mesh = new Mesh(geometry, material);
    mesh.frustumCulled = false;
    mesh.renderOrder = order;
    this.scene.add(mesh);
    return mesh;
  }
}

/** Draws a part so much farther away, as seen by the depth buffer. */
function offset(part: Mesh, by: 1 | -1): void {
  const material = part.material as RawShaderMaterial;
  material.polygonOffset = true;
  material.polygonOffsetFactor = by;
  material.polygonOffsetUnits = 4 * by;
}

/**
 * A square of side 2 in squares about its middle, each four times as large as the one inside it, to
 * be scaled by `reach`, m. The nearer to the eye the smaller the triangles: across one that is near
 * and 200 km long, places would be known to some metres only.
 */
function squares(reach: number): Float32Array<ArrayBuffer> {
  const corners = (r: number) => [[-r, -r, 0], [r, -r, 0], [r, r, 0], [-r, r, 0]];
  const triangles: number[] = [];
  for (let outer = 1, inner; outer > 0; outer = inner) {
    inner = outer * reach > 10 ? outer / 4 : 0;
    const [from, to] = [corners(inner), corners(outer)];
    for (let k = 0; k < 4; k += 1) {
      const [a, b, c, d] = [from[k]!, from[(k + 1) % 4]!, to[(k + 1) % 4]!, to[k]!];
      triangles.push(...d, ...c, ...b);
      if (inner > 0) triangles.push(...d, ...b, ...a);
    }
  }
  return new Float32Array(triangles);
}

/** The direction of a pose, length 1. */
export function forward(pose: Pose): Vec3 {
  const heading = (pose.heading * Math.PI) / 180;
  const pitch = (pose.pitch * Math.PI) / 180;
  return [Math.sin(heading) * Math.cos(pitch), Math.cos(heading) * Math.cos(pitch), Math.sin(pitch)];
}
