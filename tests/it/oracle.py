"""Asks a running service what three cameras see and works out the same in another language.

usage: oracle.py CITYLOD CITY.citylod http://ADDRESS/collections/NAME

At full detail: every object is tested against the frustum. With levels of detail: the seven steps
of Gong et al., section 2.2, set by set, over what `info --objects` and `info --nodes` list.
"""

import json
import math
import subprocess
import sys
import urllib.request

FOV_Y_DEG, WIDTH, HEIGHT, NEAR = 60.0, 1600, 900, 0.1


def listing(program, city, what):
    out = subprocess.run([program, "info", what, city], check=True, capture_output=True)
    return [json.loads(line) for line in out.stdout.splitlines()]


def sub(a, b):
    return [a[i] - b[i] for i in range(3)]


def dot(a, b):
    return sum(a[i] * b[i] for i in range(3))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(dot(a, a))
    return [x / length for x in a]


class Camera:
    def __init__(self, eye, target):
        self.eye, self.target = eye, target
        self.forward = unit(sub(target, eye))
        self.right = unit(cross(self.forward, [0, 0, 1]))
        self.up = cross(self.right, self.forward)
        self.tan_y = math.tan(math.radians(FOV_Y_DEG / 2))
        self.tan_x = self.tan_y * WIDTH / HEIGHT

    def sides(self, box):
        """For each plane, how many of the corners lie beyond it."""
        beyond = [0] * 5
        for i in range(8):
            corner = [box[axis + (3 if i >> axis & 1 else 0)] for axis in range(3)]
            to = sub(corner, self.eye)
            x, y, z = dot(to, self.right), dot(to, self.up), dot(to, self.forward)
            values = [z - NEAR, z * self.tan_x - x, z * self.tan_x + x,
                      z * self.tan_y - y, z * self.tan_y + y]
            for plane, value in enumerate(values):
                beyond[plane] += value < 0
        return beyond

    def outside(self, box):
        return 8 in self.sides(box)

    def inside(self, box):
        return not any(self.sides(box))

    def distance(self, box):
        gaps = [max(box[i] - self.eye[i], self.eye[i] - box[i + 3], 0) for i in range(3)]
        return math.sqrt(dot(gaps, gaps))


def seven_steps(camera, nodes, boxes, far_dist, factor, levels):
    """Steps 1 to 7. `levels` covers the tree, so that every level has a range."""
    found = set()
    todo = [(0, 2)]
    while todo:
        number, step = todo.pop()
        node = nodes[number]
        whole = step == 3 or camera.inside(node["bounds"])
        if step == 2 and camera.outside(node["bounds"]):
            continue
        level = node["level"]
        near = 0 if level == 0 else far_dist * factor ** (level - 1)
        far = math.inf if level == levels - 1 else far_dist * factor**level
        distance = camera.distance(node["bounds"])
        if distance >= far:
            continue
        found |= {o for o in node["objects"] if whole or not camera.outside(boxes[o])}
        if distance < near:
            todo += [(child, 3 if whole else 2) for child in node["children"]]
    return found


def ask(url, camera, lod):
    body = {
        "camera": {"eye": camera.eye, "target": camera.target, "fov_y_deg": FOV_Y_DEG,
                   "viewport": [WIDTH, HEIGHT], "near": NEAR},
        "lod": lod,
    }
    request = urllib.request.Request(
        url + "/visible", json.dumps(body).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=30) as answer:
        ids = json.load(answer)["ids"]
    assert len(ids) == len(set(ids)), "an id comes twice"
    return set(ids)


def main(program, city, url):
    objects = listing(program, city, "--objects")
    nodes = listing(program, city, "--nodes")
    ids = {o["index"]: o["id"] for o in objects}
    boxes = {o["index"]: o["bounds"] for o in objects}
    root = nodes[0]["bounds"]
    levels = nodes[0]["level"] + 1
    middle = [(root[i] + root[i + 3]) / 2 for i in range(3)]
    wide = root[3] - root[0]
    ground = root[2]
    poses = [  # from the street, aslant, from above
        Camera([middle[0], middle[1], ground + 15], [middle[0] + 100, middle[1] + 70, ground + 20]),
        Camera([middle[0] - wide / 3, middle[1] - wide / 3, ground + 300], [middle[0], middle[1], ground]),
        Camera([middle[0], middle[1], ground + wide / 6], [middle[0] + 20, middle[1] + 1, ground]),
    ]
    for camera in poses:
        everything = {"far_dist_m": None, "levels": 1}
        brute = {ids[o] for o in boxes if not camera.outside(boxes[o])}
        assert ask(url, camera, everything) == brute, "full detail differs from brute force"
        far_dist, factor = wide / 12, 2.5
        lod = {"far_dist_m": far_dist, "dist_factor": factor, "levels": levels}
        steps = {ids[o] for o in seven_steps(camera, nodes, boxes, far_dist, factor, levels)}
        assert ask(url, camera, lod) == steps, "LOD differs from the seven steps"
        assert 0 < len(steps) < len(brute), (len(steps), len(brute))
        print(f"{len(brute)} at full detail, {len(steps)} with LOD")


main(*sys.argv[1:])
