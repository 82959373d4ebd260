use citylod::terrain::read::{Options, read};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::elevation_files::{
    ASC, ASCII, Tiff, deflated, empty_tiff, picture, read_bytes, tiled, with,
};

/// Each file must be refused with all its words.
fn refused(table: &[(&str, Vec<u8>, &[&str])]) {
    let mut wrong = Vec::new();
    for (name, bytes, words) in table {
        match read_bytes(name, bytes) {
            Ok(_) => wrong.push(format!("{name} was taken")),
            Err(said) if words.iter().all(|word| said.contains(word)) => {}
            Err(said) => wrong.push(format!("{name}: {words:?} are not in {said:?}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
#[allow(clippy::too_many_lines, reason = "a table")]
fn broken_tiffs_are_refused_with_the_place() {
    let bomb = deflated(&vec![0; 40_000_000]);
    refused(&[
        ("a.tif", b"no raster".to_vec(), &["signature"][..]),
        ("b.tif", vec![], &["signature"]),
        ("c.tif", Tiff::small().bytes()[..30].to_vec(), &["cut off"]),
        (
            "d.tif",
            with(|t| {
                t.long(256, &[60_000])
                    .long(257, &[60_000])
                    .long(278, &[60_000])
            }),
            &["60000 x 60000 posts", "coarser"],
        ),
        (
            "e.tif",
            with(|t| {
                t.long(256, &[10_000])
                    .long(257, &[10_000])
                    .long(278, &[10_000])
            }),
            &["do not fit"],
        ),
        (
            "f.tif",
            with(|t| t.long(256, &[0])),
            &["no readable TIFF", "0x2"],
        ),
        (
            "g.tif",
            with(|t| t.long(273, &[4_000_000_000])),
            &["strip or tile 0", "cut off"],
        ),
        (
            "h.tif",
            with(|t| t.long(279, &[4_000_000_000])),
            &["strip or tile 0"],
        ),
        ("i.tif", with(|t| t.short(278, &[0])), &["no readable TIFF"]),
        ("j.tif", with(|t| t.short(277, &[3])), &["gdal_translate"]),
        (
            "k.tif",
            with(|t| t.short(259, &[50_000])),
            &["not supported", "COMPRESS=DEFLATE"],
        ),
        (
            "l.tif",
            with(|t| t.without(33922)),
            &["does not say where it lies"],
        ),
        (
            "m.tif",
            with(|t| t.double(33550, &[0.0, 0.0, 0.0])),
            &["spacing must be positive"],
        ),
        (
            "n.tif",
            with(|t| t.double(33550, &[f64::NAN, 1.0, 0.0])),
            &["origin must be finite"],
        ),
        (
            "o.tif",
            with(|t| t.short(34735, &[1, 1, 0, 900, 1024, 0, 1, 1])),
            &["GeoKeyDirectory"],
        ),
        (
            "p.tif",
            with(|t| t.short(34735, &[1, 1, 0, 1, 1024, 0, 1, 3])),
            &["model type 3", "gdalwarp"],
        ),
        (
            "q.tif",
            with(|t| t.short(34735, &[1, 1, 0, 1, 4099, 0, 1, 9002])),
            &["heights in unit EPSG:9002"],
        ),
        (
            "r.tif",
            with(|t| t.put(42113, ASCII, b"hole\0", 5)),
            &["GDAL_NODATA", "hole"],
        ),
        ("s.tif", with(|t| tiled(t, 3_000_000_000)), &["do not fit"]),
        ("t.tif", with(|t| tiled(t, 0)), &["t.tif"]),
        (
            "u.tif",
            with(|t| t.short(259, &[8]).holding(b"no deflate")),
            &["strip or tile 0"],
        ),
        ("w.tif", empty_tiff(16_000), &["do not fit"]),
        (
            "v.tif",
            with(|t| {
                t.short(259, &[8])
                    .long(279, &[bomb.len() as u32])
                    .long(256, &[10_000])
                    .long(257, &[20_000]);
                t.long(278, &[20_000]).holding(&bomb) // 40 MB of the 400 MB that the raster takes
            }),
            &["v.tif"],
        ),
    ]);
}

#[test]
fn broken_ascii_grids_are_refused_with_the_line() {
    refused(&[
        (
            "a.asc",
            b"ncols 3\nnrows\n".to_vec(),
            &["line 3", "number after \"nrows\""],
        ),
        (
            "b.asc",
            ASC.replace("6.5", "six").into(),
            &["line 8", "\"six\""],
        ),
        (
            "c.asc",
            ASC.replace("6.5", "").into(),
            &["line 8", "5 of 6 heights"],
        ),
        (
            "d.asc",
            ASC.replace("6.5", "6.5 7").into(),
            &["line 8", "more than the 6"],
        ),
        (
            "e.asc",
            ASC.replace("ncols 3", "ncols 30000").into(),
            &["60000 heights", "room for"],
        ),
        (
            "f.asc",
            ASC.replace("ncols 3", "ncols 99999999999").into(),
            &["99999999999 x 2 posts"],
        ),
        (
            "g.asc",
            ASC.replace("ncols 3", "ncols 2.5").into(),
            &["ncols"],
        ),
        (
            "h.asc",
            ASC.replace("cellsize 10", "cellsize -10").into(),
            &["cellsize"],
        ),
        (
            "i.asc",
            ASC.replace("cellsize 10", "cellsize inf").into(),
            &["line 5"],
        ),
        (
            "j.asc",
            ASC.replace("cellsize", "celsize").into(),
            &["line 5", "celsize"],
        ),
        ("k.asc", vec![b'7'; 5_000_000], &["line 1", "no ASCII grid"]),
        ("l.asc", vec![0xff; 100], &["line 1"]),
        ("m.asc", ASC.replace("6.5", "1e99").into(), &["from zero"]),
        ("n.asc", vec![], &["no usable ncols"]),
    ]);
}

#[test]
fn other_broken_elevation_is_refused() {
    refused(&[
        ("hill.hgt", vec![0; 8], &["N40W106"]),
        ("N40W190.hgt", vec![0; 8], &["corner"]),
        ("N40W106.hgt", vec![0; 10], &["10 bytes"]),
        ("N41W106.hgt", vec![0; 2], &["2 bytes"]),
        ("N42W106.hgt", vec![0; 9], &["9 bytes"]),
        ("a.png", b"no picture".to_vec(), &["a.png"]),
        (
            "b.png",
            picture(2, 1, &[10, 0, 0, 10, 0, 0]),
            &["--encoding"],
        ),
        ("c.png", picture(2, 1, &[1; 6])[..50].to_vec(), &["c.png"]),
        (
            "d.png",
            picture(4000, 4000, &vec![1; 48_000_000])[..9000].to_vec(),
            &["d.png"],
        ),
        ("a.dem", vec![], &[".asc"]),
    ]);
}

/// Whatever happens to its bytes, a file is read or refused.
#[test]
fn damaged_files_never_panic() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut packed = Tiff::small();
    packed
        .holding(&deflated(&[7; 512]))
        .short(259, &[8])
        .short(317, &[2]);
    tiled(&mut packed, 16);
    let originals = [
        ("a.tif", Tiff::small().bytes()),
        ("b.tif", packed.bytes()),
        ("a.asc", ASC.into()),
        ("N01E001.hgt", vec![1; 18]),
        ("a.png", picture(2, 3, &[1; 18])),
    ];
    let folder = tempfile::tempdir().unwrap();
    let (mut taken, mut refused) = (0, 0);
    for (name, original) in &originals {
        let path = folder.path().join(name);
        assert!(read_bytes(name, original).is_ok(), "{name}");
        for _ in 0..1500 {
            let mut bytes = original.clone();
            for _ in 0..random.random_range(1..4) {
                let at = random.random_range(0..bytes.len());
                match random.random_range(0..5) {
                    0 => bytes.truncate(at.max(1)),
                    1 => bytes[at] ^= 1 << random.random_range(0..8),
                    2 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][random.random_range(0..5)],
                    3 => drop(bytes.remove(at)),
                    _ => bytes.insert(at, random.random()),
                }
                if bytes.is_empty() {
                    bytes.push(0);
                }
            }
            std::fs::write(&path, &bytes).unwrap();
            let options = Options {
                bounds: Some([0.0, 0.0, 100.0, 100.0]),
                ..Options::default()
            };
            match read(&path, &options) {
                Ok(raster) => {
                    taken += 1;
                    assert!(raster.field.grid().count() <= 1 << 20, "{name}");
                }
                Err(_) => refused += 1,
            }
        }
    }
    assert!(
        taken > 500 && refused > 500,
        "{taken} taken, {refused} refused"
    );
}
