use std::path::Path;

use super::server::{Running, demo};

/// What the page names below `/assets/`.
fn assets(page: &str) -> Vec<&str> {
    page.split('"')
        .filter(|text| text.starts_with("/assets/"))
        .collect()
}

#[test]
fn the_front_page_is_the_viewer_or_says_that_there_is_none() {
    let service = Running::new();
    let reply = service.send("GET", "/", &[("Accept", "text/html")], b"");
    let page = String::from_utf8(reply.body.clone()).unwrap();
    let about = String::from_utf8(service.get("/about").body).unwrap();
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).join("viewer/dist/index.html");
    if !built.exists() {
        println!("this build has no viewer");
        for page in [page, about] {
            assert!(page.contains("This build has no viewer: Node.js"), "{page}");
        }
        return;
    }
    assert!(!about.contains("no viewer"));
    assert!(about.contains("href=\"/\""), "the way to the viewer");
    let policy = reply.header("content-security-policy").unwrap();
    assert!(policy.contains("default-src 'self'"), "{policy}");
    let tag = reply.header("etag").unwrap();
    let known = [("Accept", "text/html"), ("If-None-Match", tag)];
    assert_eq!(service.send("GET", "/", &known, b"").status, 304);
    let assets = assets(&page);
    for kind in ["js", "css"] {
        assert!(
            assets.iter().any(|a| a.ends_with(kind)),
            "{kind}: {assets:?}"
        );
    }
    for asset in assets {
        let plain = service.get(asset);
        assert_eq!(plain.status, 200, "{asset}");
        let kept = plain.header("cache-control").unwrap();
        assert!(kept.contains("immutable"), "{asset}: {kept}");
        let media_type = plain.header("content-type").unwrap();
        let expected = match asset.rsplit('.').next().unwrap() {
            "js" => "text/javascript",
            "css" => "text/css",
            other => panic!("a page of scripts and styles has {other}"),
        };
        assert_eq!(media_type, expected, "{asset}");
        let packed = service.send("GET", asset, &[("Accept-Encoding", "gzip")], b"");
        assert_eq!(packed.header("content-encoding"), Some("gzip"), "{asset}");
        let mut unpacked = Vec::new();
        let mut reader = flate2::read::GzDecoder::new(&packed.body[..]);
        std::io::Read::read_to_end(&mut reader, &mut unpacked).unwrap();
        assert_eq!(unpacked, plain.body, "{asset}");
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("viewer/dist{asset}.gz"));
        assert_eq!(packed.body, std::fs::read(file).unwrap(), "{asset}");
        for unwanted in ["gzip;q=0", "br"] {
            let headers = [("Accept-Encoding", unwanted)];
            let reply = service.send("GET", asset, &headers, b"");
            assert_eq!(reply.body, plain.body, "{asset}: {unwanted}");
        }
    }
}

#[test]
fn only_parts_of_the_viewer_are_served() {
    let service = Running::new();
    for name in [
        "nothing.js",
        "..%2Findex.html",
        "..%2F..%2FCargo.toml",
        "%2Fetc%2Fpasswd",
    ] {
        let problem = service.get(&format!("/assets/{name}")).problem(404);
        assert_eq!(problem["pointer"], "file", "{name}");
    }
}

#[test]
fn ids_and_classes_in_bulk_are_those_of_the_items() {
    let service = Running::new();
    let tree = demo();
    for (start, end) in [(0, 0), (0, 7), (1_500, 1_530), (2_990, 3_000)] {
        let reply = service.get(&format!(
            "/collections/demo/items?start={start}&end={end}&revision={}",
            tree.revision()
        ));
        assert!(reply.header("cache-control").unwrap().contains("immutable"));
        let items = reply.json();
        assert_eq!(items["start"], start);
        let ids = items["ids"].as_array().unwrap();
        let classes = items["classes"].as_array().unwrap();
        assert_eq!((ids.len(), classes.len()), (end - start, end - start));
        for (at, (id, class)) in ids.iter().zip(classes).enumerate() {
            let object = tree.object((start + at) as u32).unwrap();
            assert_eq!(id, &*object.id);
            let class = class.as_u64().unwrap() as usize;
            assert_eq!(tree.classes()[class], object.class);
        }
    }
    let all = service.get("/collections/demo/items").json();
    assert_eq!(all["ids"].as_array().unwrap().len(), 3_000);
}
