/** A view that was frozen, seen from outside: its eye, its edges and its window. */

import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  GLSL3,
  Group,
  LineSegments,
  Mesh,
  type PerspectiveCamera,
  RawShaderMaterial,
  Vector3,
  Vector4,
} from 'three';
import { plainFragment, plainVertex } from './shaders';

function plain(alpha: number): RawShaderMaterial {
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: plainVertex,
    fragmentShader: plainFragment,
    uniforms: { uColour: { value: new Vector4(0, 0, 0, alpha) } },
    transparent: true,
    depthWrite: false,
    side: DoubleSide,
  });
}

export class Frozen {
  readonly group = new Group();
  private readonly edges = new LineSegments(new BufferGeometry(), plain(0.95));
  private readonly sides = new Mesh(new BufferGeometry(), plain(0.08));

  constructor() {
    this.group.visible = false;
    for (const part of [this.sides, this.edges]) {
      part.frustumCulled = false;
      part.renderOrder = 5;
      this.group.add(part);
    }
  }

  /** Shows what this camera sees, as far as `reach` metres. */
  show(camera: PerspectiveCamera, reach: number): void {
    const eye = camera.position.clone();
    const corner = (x: number, y: number, far: number) => {
      const way = new Vector3(x, y, 0.5).unproject(camera).sub(eye).normalize();
      const forward = new Vector3();
      camera.getWorldDirection(forward);
      return eye.clone().addScaledVector(way, far / way.dot(forward));
    };
    const ring = ([[-1, -1], [1, -1], [1, 1], [-1, 1]] as const).map(([x, y]) => [x, y] as const);
    const far = ring.map(([x, y]) => corner(x, y, reach));
    const near = ring.map(([x, y]) => corner(x, y, reach * 0.06));
    const edges: Vector3[] = [];
    const sides: Vector3[] = [];
    ring.forEach((_, k) => {
      const next = (k + 1) % 4;
      edges.push(eye, far[k]!, far[k]!, far[next]!, near[k]!, near[next]!);
      sides.push(eye, far[k]!, far[next]!);
    });
    this.fill(this.edges, edges);
    this.fill(this.sides, sides);
    this.group.visible = true;
  }

  hide(): void {
    this.group.visible = false;
  }

  colour(colour: Color): void {
    const { r, g, b } = colour;
    for (const part of [this.edges, this.sides]) {
      const value = (part.material as RawShaderMaterial).uniforms['uColour']!.value as Vector4;
      value.set(r, g, b, value.w);
    }
  }

  private fill(part: LineSegments | Mesh, points: Vector3[]): void {
    part.geometry.dispose();
    part.geometry = new BufferGeometry();
    const places = new Float32Array(points.flatMap((p) => p.toArray()));
    part.geometry.setAttribute('position', new BufferAttribute(places, 3));
  }
}
