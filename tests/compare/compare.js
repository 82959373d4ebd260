// Triangles of citylod, martini and delatin at the same largest error, on made-up ground and on
// ESRI ASCII grids: npm run compare -- [FILE.asc ...]
//
// The error is the largest vertical distance of any post from the mesh, measured here for every
// mesh, whoever made it. Martini is given errors of its own kind (that of midpoints); the others
// get what its mesh then measures. Ends with 1 where citylod errs by more, or draws more than 1.5
// times martini's triangles.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import Martini from "@mapbox/martini";
import Delatin from "delatin";

const MOST_TIMES_MARTINI = 1.5;
// Errors are known as f32 to citylod.
const ROUNDING = 1 + 2e-6;
const SHARES_OF_RELIEF = [0.002, 0.005, 0.01, 0.02, 0.05, 0.1];

/** A square of 2^k + 1 posts from a function of column and row. */
function ground(name, size, height) {
  const heights = new Float32Array(size * size);
  for (let y = 0; y < size; y++) for (let x = 0; x < size; x++) heights[y * size + x] = height(x, y);
  return { name, size, heights };
}

/** Value noise: smooth between random values at whole coordinates, −1 to 1. */
function noise(x, y, seed) {
  const value = (x, y) => {
    let h = Math.imul(x, 0x9e3779b1) ^ Math.imul(y, 0x85ebca77) ^ Math.imul(seed, 0x27d4eb2f);
    h = Math.imul(h ^ (h >>> 15), 0x2c1b3c6d);
    h = Math.imul(h ^ (h >>> 12), 0x297a2d39);
    return ((h ^ (h >>> 15)) >>> 0) / 2 ** 31 - 1;
  };
  const smooth = (t) => t * t * (3 - 2 * t);
  const [x0, y0] = [Math.floor(x), Math.floor(y)];
  const [tx, ty] = [smooth(x - x0), smooth(y - y0)];
  const along = (y) => value(x0, y) * (1 - tx) + value(x0 + 1, y) * tx;
  return along(y0) * (1 - ty) + along(y0 + 1) * ty;
}

function mountains(x, y) {
  let height = 0;
  for (let n = 1; n < 9; n++) height += noise((x * 2 ** n) / 512, (y * 2 ** n) / 512, n) / 1.9 ** n;
  return 1000 * height;
}

const cliff = (x, y) => (x * 3 + y > 700 ? 300 : 0) + 20 * Math.sin(x / 9) * Math.cos(y / 13);
const hills = (x, y) => 100 * Math.sin(x / 41) * Math.cos(y / 67) + 10 * Math.sin((x + 2 * y) / 17);

/** The largest square of 2^k + 1 posts about the middle of an ASCII grid. */
function asciiGrid(path) {
  const words = readFileSync(path, "latin1").trim().split(/\s+/);
  const head = {};
  while (/^[a-z]/i.test(words[0])) head[words.shift().toLowerCase()] = Number(words.shift());
  const { ncols, nrows } = head;
  const size = 2 ** Math.floor(Math.log2(Math.min(ncols, nrows) - 1)) + 1;
  const [left, top] = [(ncols - size) >> 1, (nrows - size) >> 1];
  const made = ground(basename(path), size, (x, y) => words[(top + y) * ncols + left + x]);
  return made.heights.includes(head.nodata_value) || made.heights.some(Number.isNaN) ? null : made;
}

/** Largest vertical distance of a post from the triangle over or under it. */
function error({ size, heights }, vertices, triangles) {
  let worst = 0;
  const seen = new Uint8Array(size * size);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => {
      const v = triangles[t + k];
      const [x, y] = [vertices[2 * v], vertices[2 * v + 1]];
      return { x, y, z: heights[y * size + x] };
    });
    const area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    const between = (p, q, r) => [Math.min(p, q, r), Math.max(p, q, r)];
    const [west, east] = between(a.x, b.x, c.x);
    const [south, north] = between(a.y, b.y, c.y);
    for (let y = south; y <= north; y++) {
      for (let x = west; x <= east; x++) {
        const wa = ((b.x - x) * (c.y - y) - (c.x - x) * (b.y - y)) / area;
        const wb = ((c.x - x) * (a.y - y) - (a.x - x) * (c.y - y)) / area;
        const wc = ((a.x - x) * (b.y - y) - (b.x - x) * (a.y - y)) / area;
        if (wa < 0 || wb < 0 || wc < 0) continue;
        seen[y * size + x] = 1;
        worst = Math.max(worst, Math.abs(wa * a.z + wb * b.z + wc * c.z - heights[y * size + x]));
      }
    }
  }
  if (seen.includes(0)) throw new Error("a post is not covered");
  return worst;
}

/** Meshes of citylod, one for each largest error. */
function citylod({ size, heights }, errors) {
  const folder = mkdtempSync(join(tmpdir(), "citylod-compare-"));
  try {
    const file = join(folder, "heights.f32");
    writeFileSync(file, heights);
    const run = ["run", "--release", "--quiet", "--example", "ground_mesh", "--", file, size, ...errors];
    const told = execFileSync("cargo", run.map(String), { maxBuffer: 2 ** 30, encoding: "utf8" });
    return told.trim().split("\n").map(JSON.parse);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

const grounds = [
  ground("mountains", 513, mountains),
  ground("hills", 257, hills),
  ground("cliff", 257, cliff),
];
for (const path of process.argv.slice(2)) {
  const made = asciiGrid(path);
  if (made) grounds.push(made);
  else console.error(`left out, it has holes: ${path}`);
}
console.log("| ground | posts | largest error | martini | delatin | citylod | to martini |");
console.log("|---|---:|---:|---:|---:|---:|---:|");
let worst = 0;
for (const made of grounds) {
  const { name, size, heights } = made;
  const [low, high] = heights.reduce(([l, h], z) => [Math.min(l, z), Math.max(h, z)], [1e9, -1e9]);
  const tile = new Martini(size).createTile(heights);
  const theirs = SHARES_OF_RELIEF.map((share) => {
    const { vertices, triangles } = tile.getMesh(share * (high - low));
    return { count: triangles.length / 3, error: error(made, vertices, triangles) };
  });
  const ours = citylod(made, theirs.map((mesh) => mesh.error));
  theirs.forEach((martini, n) => {
    if (martini.count === theirs[n - 1]?.count) return;
    const found = error(made, ours[n].posts, ours[n].triangles);
    if (!(found <= martini.error * ROUNDING)) {
      throw new Error(`${name}: ${found} m is more than the ${martini.error} m asked for`);
    }
    const delatin = new Delatin(heights, size, size);
    delatin.run(martini.error);
    const count = ours[n].triangles.length / 3;
    const times = count / martini.count;
    worst = Math.max(worst, times);
    const cells = [name, size * size, martini.error.toPrecision(3), martini.count];
    cells.push(delatin.triangles.length / 3, count, times.toFixed(2));
    console.log(`| ${cells.join(" | ")} |`);
  });
}
console.log(`\nAt most ${worst.toFixed(2)} times martini's triangles.`);
process.exitCode = worst <= MOST_TIMES_MARTINI ? 0 : 1;
