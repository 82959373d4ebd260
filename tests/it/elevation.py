"""Elevation as rasterio reads it: writes files of every kind, and judges what was read of them.

write FOLDER       makes rasters in FOLDER, one for each way a GeoTIFF can hold heights
judge < REPORT     one JSON object a line: {"file", "points": [[x, y, height or null], ...],
                   "bounds": null or [w, s, e, n], "plane": null or "EPSG:..."}

Without a plane, a point's height is that of the cell it lies in. With one, points are metres on
it, and heights are bilinear between the centres of cells. Ends with 1 at the first disagreement.
"""

import json
import sys

import numpy
import rasterio
from rasterio.transform import from_bounds, from_origin
from rasterio.warp import transform

# Metres between bilinear heights: f32 rounding at 5,000 m, and a micrometre of position.
TOLERANCE = 2e-3


def write(folder):
    random = numpy.random.default_rng(1)
    relief = random.integers(0, 3000, (211, 167))
    place = from_origin(500_000.0, 5_400_000.0, 25.0, 10.0)
    kinds = {
        "int16-strips": dict(dtype="int16", nodata=7),
        "uint16-tiles": dict(dtype="uint16", tiled=True, blockxsize=64, blockysize=32, compress="deflate", predictor=2),
        "float32-tiles": dict(dtype="float32", tiled=True, blockxsize=128, blockysize=128, compress="deflate", predictor=3, nodata=-9999),
        "float32-lzw": dict(dtype="float32", compress="lzw", nodata=-3.4028234663852886e38),
        "float64-bigtiff": dict(dtype="float64", BIGTIFF="YES", nodata=float("nan")),
        "int32-packbits": dict(dtype="int32", compress="packbits", nodata=-32768),
        "uint8": dict(dtype="uint8", compress="deflate"),
        "big-endian": dict(dtype="int16", ENDIANNESS="BIG", compress="lzw", predictor=2),
        "sparse": dict(dtype="int16", tiled=True, blockxsize=64, blockysize=64, SPARSE_OK="TRUE", nodata=0),
    }
    for name, options in kinds.items():
        values = relief.astype(options["dtype"])
        if values.dtype.kind == "f":
            values = values + values.dtype.type(0.37)
        holes = options.get("nodata")
        if holes is not None:
            values[40:60, 20:90] = holes
        if name == "sparse":
            values[:128, :128] = 0
        with rasterio.open(
            f"{folder}/{name}.tif", "w", driver="GTiff", width=167, height=211, count=1,
            crs="EPSG:32632", transform=place, **options,
        ) as out:
            out.write(values, 1)
    with rasterio.open(
        f"{folder}/point.tif", "w", driver="GTiff", width=167, height=211, count=1, dtype="int16",
        crs="EPSG:4326", transform=from_origin(7.0, 46.0, 0.001, 0.002),
    ) as out:
        out.update_tags(AREA_OR_POINT="Point")
        out.write(relief.astype("int16"), 1)
    with rasterio.open(
        f"{folder}/N46E007.hgt", "w", driver="SRTMHGT", width=1201, height=1201, count=1,
        dtype="int16", crs="EPSG:4326",
        transform=from_origin(7 - 1 / 2400, 47 + 1 / 2400, 1 / 1200, 1 / 1200),
    ) as out:
        values = random.integers(-50, 4800, (1201, 1201)).astype("int16")
        values[100:140, 300:900] = -32768
        out.write(values, 1)


    with rasterio.open(
        f"{folder}/grid.asc", "w", driver="AAIGrid", width=167, height=211, count=1,
        dtype="float32", crs="EPSG:32632", transform=from_origin(500_000.0, 5_400_000.0, 25.0, 25.0),
        nodata=-9999,
    ) as out:
        values = relief.astype("float32") * 1.37 - 400
        values[40:60, 20:90] = -9999
        out.write(values, 1)
    decimetres = relief * 10 + 100_000 - 4321
    terrarium = relief * 256 + 32768 * 256 - 1_000_000
    for name, coded in (("terrain-rgb", decimetres), ("terrarium", terrarium)):
        with rasterio.open(
            f"{folder}/{name}.png", "w", driver="PNG", width=167, height=211, count=3, dtype="uint8",
        ) as out:
            out.write(numpy.stack([coded >> 16, coded >> 8 & 255, coded & 255]).astype("uint8"))


def heights(path, bounds):
    """Heights with NaN for no data, and the transform of cells."""
    with rasterio.open(path) as file:
        if path.endswith(".png"):
            r, g, b = (file.read(band).astype(float) for band in (1, 2, 3))
            values = r * 256 + g + b / 256 - 32768
            if path.endswith("terrain-rgb.png"):
                values = (r * 65536 + g * 256 + b) * 0.1 - 10000
            return values, from_bounds(*bounds, file.width, file.height)
        values = file.read(1).astype(float)
        if file.nodata is not None:
            values[values == file.nodata] = numpy.nan
        return values, file.transform


def bilinear(values, column, row):
    """Between centres of cells; NaN outside and where a neighbour that counts is."""
    c, r = column - 0.5, row - 0.5
    last_row, last_column = values.shape[0] - 1, values.shape[1] - 1
    if not (0 <= c <= last_column and 0 <= r <= last_row):
        return numpy.nan
    c0, r0 = min(int(c), last_column - 1), min(int(r), last_row - 1)
    fc, fr = c - c0, r - r0
    square = values[r0 : r0 + 2, c0 : c0 + 2]
    weights = numpy.outer([1 - fr, fr], [1 - fc, fc])
    return float((square * weights)[weights > 0].sum())


def judge():
    agreed = 0
    for line in sys.stdin:
        report = json.loads(line)
        values, cells = heights(report["file"], report["bounds"])
        points = report["points"]
        xs, ys = [p[0] for p in points], [p[1] for p in points]
        if report["plane"]:
            xs, ys = transform(report["plane"], "EPSG:4326", xs, ys)
        for (x, y, point) in zip(xs, ys, points):
            column, row = ~cells * (x, y)
            if report["plane"]:
                # Positions agree to a micrometre only: not to be judged at the edge of data.
                near = [bilinear(values, column + dc, row + dr) for dc in (-1e-4, 1e-4) for dr in (-1e-4, 1e-4)]
                if any(numpy.isnan(h) for h in near) != all(numpy.isnan(h) for h in near):
                    continue
                expected, tolerance = bilinear(values, column, row), TOLERANCE
            else:
                expected, tolerance = values[int(row), int(column)], 0.0
                expected = float(numpy.float32(expected))
            found = point[2]
            if (found is None) != bool(numpy.isnan(expected)) or (
                found is not None and abs(found - expected) > tolerance
            ):
                sys.exit(f"{report['file']}: at {point[0]} {point[1]} found {found}, expected {expected}")
            agreed += 1
    print(f"{agreed} heights agree")


if sys.argv[1] == "write":
    write(sys.argv[2])
else:
    judge()
