use super::server::Running;

/// Body, status, pointer.
const BODIES: &[(&str, u16, &str)] = &[
    // Not JSON.
    ("", 400, ""),
    ("   ", 400, ""),
    ("camera", 400, ""),
    (r#"{"camera":{"eye":[0,0,1],"target":[0,0,0]}"#, 400, ""),
    (r#"{"camera":{"eye":[0,0,1],"tar"#, 400, "/camera"),
    (
        r#"{"camera":{"eye":[NaN,0,1],"target":[0,0,0]}}"#,
        400,
        "/camera/eye/0",
    ),
    (
        r#"{"camera":{"eye":[0,-Infinity,1],"target":[0,0,0]}}"#,
        400,
        "/camera/eye/1",
    ),
    (
        r#"{"camera":{"eye":[0,0,01],"target":[0,0,0]}}"#,
        400,
        "/camera/eye/2",
    ),
    (r#"{"camera":{"eye":[0,0,1],"target":[0,0,0]}} {}"#, 400, ""),
    ("{'camera':{}}", 400, ""),
    (r#"{"camera":"\ud83c"}"#, 400, "/camera"),
    (r#"{"camera":"\udfe0"}"#, 400, "/camera"),
    (r#"{"camera":"\ud83c\u0041"}"#, 400, "/camera"),
    // Out of f64.
    (
        r#"{"camera":{"eye":[0,1e999,1],"target":[0,0,0]}}"#,
        400,
        "/camera/eye/1",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[0,0,0]},"lod":{"far_dist_m":-1e999}}"#,
        400,
        "/lod/far_dist_m",
    ),
    // Wrong types.
    ("null", 400, ""),
    ("[]", 400, ""),
    ("17", 400, ""),
    (r#""camera""#, 400, ""),
    (r#"{"camera":[[0,0,1],[0,0,0]]}"#, 400, "/camera"),
    (
        r#"{"camera":{"eye":[0,"1",1],"target":[0,0,0]}}"#,
        400,
        "/camera/eye/1",
    ),
    (
        r#"{"camera":{"eye":[0,null,1],"target":[0,0,0]}}"#,
        400,
        "/camera/eye/1",
    ),
    (
        r#"{"camera":{"eye":{"x":0},"target":[0,0,0]}}"#,
        400,
        "/camera/eye",
    ),
    (
        r#"{"camera":{"eye":[0,0],"target":[0,0,0]}}"#,
        400,
        "/camera/eye",
    ),
    (
        r#"{"camera":{"eye":[0,0,0,1],"target":[0,0,0]}}"#,
        400,
        "/camera/eye",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":null}}"#,
        400,
        "/camera/target",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[0,0,0],"fov_y_deg":"60"}}"#,
        400,
        "/camera/fov_y_deg",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[0,0,0],"near":null}}"#,
        400,
        "/camera/near",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[0,0,0],"viewport":[1920.5,1080]}}"#,
        400,
        "/camera/viewport/0",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[0,0,0],"viewport":[1920,-1080]}}"#,
        400,
        "/camera/viewport/1",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"view_projection":[1,0,0,0]}}"#,
        400,
        "/camera/view_projection",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":[]}"#,
        400,
        "/lod",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":null}"#,
        400,
        "/lod",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"errors"}}"#,
        400,
        "/lod/mode",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"error","max_error_px":null}}"#,
        400,
        "/lod/max_error_px",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"budget","max_objects":-1}}"#,
        400,
        "/lod/max_objects",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"budget","max_objects":2.5}}"#,
        400,
        "/lod/max_objects",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":{"range":null}}}"#,
        400,
        "/lod/mode",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"beyond":"fade"}}"#,
        400,
        "/lod/beyond",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"levels":1.5}}"#,
        400,
        "/lod/levels",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"dist_factor":null}}"#,
        400,
        "/lod/dist_factor",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"output":{"form":"xml"}}"#,
        400,
        "/output/form",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"output":"ids"}"#,
        400,
        "/output",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"effects":[]}"#,
        400,
        "/effects",
    ),
    // Missing, unknown, twice.
    ("{}", 400, "/camera"),
    (r#"{"camera":{"target":[0,0,0]}}"#, 400, "/camera/eye"),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"cam":1}"#,
        400,
        "/cam",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"fov":60}}"#,
        400,
        "/camera/fov",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"a/b~":1}}"#,
        400,
        "/lod/a~1b~0",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"feedback":{"target":16}}"#,
        400,
        "/feedback/target",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"eye":[0,0,2],"target":[0,0,0]}}"#,
        400,
        "/camera/eye",
    ),
    // Words that the parser puts behind what it says.
    (
        r#"{"camera":{"eye":"north at line 1"}}"#,
        400,
        "/camera/eye",
    ),
    (
        r#"{"north at line 1 column 2":1}"#,
        400,
        "/north at line 1 column 2",
    ),
    // Alternatives that exclude each other, or none of them.
    (r#"{"camera":{"eye":[0,0,1]}}"#, 422, "/camera/target"),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[0,0,0],"quaternion":[0,0,0,1]}}"#,
        422,
        "/camera/quaternion",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"up":[0,0,1],"quaternion":[0,0,0,1]}}"#,
        422,
        "/camera/quaternion",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"fov_y_deg":60,"orthographic_height_m":5}}"#,
        422,
        "/camera/orthographic_height_m",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"fov_y_deg":60,"off_axis":[-1,1,-1,1]}}"#,
        422,
        "/camera/off_axis",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"near":1,"view_projection":[1,0,0,0,0,1,0,0,0,0,-1,-1,0,0,0,1]}}"#,
        422,
        "/camera/view_projection",
    ),
    // Values that cannot be.
    (
        r#"{"camera":{"eye":[0,0,1],"target":[0,0,1]}}"#,
        422,
        "/camera/target",
    ),
    (
        r#"{"camera":{"eye":[1e308,0,1],"target":[-1e308,0,1]}}"#,
        422,
        "/camera/target",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[0,0,0],"up":[0,0,1]}}"#,
        422,
        "/camera/up",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[1,0,1],"up":[-2,0,0]}}"#,
        422,
        "/camera/up",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[1,0,1],"up":[0,0,0]}}"#,
        422,
        "/camera/up",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"quaternion":[0,0,0,0]}}"#,
        422,
        "/camera/quaternion",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"fov_y_deg":0}}"#,
        422,
        "/camera/fov_y_deg",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"fov_y_deg":180}}"#,
        422,
        "/camera/fov_y_deg",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"fov_y_deg":-60}}"#,
        422,
        "/camera/fov_y_deg",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"near":0}}"#,
        422,
        "/camera/near",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"near":10,"far":10}}"#,
        422,
        "/camera/far",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"near":10,"far":1}}"#,
        422,
        "/camera/far",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"viewport":[0,1080]}}"#,
        422,
        "/camera/viewport",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"orthographic_height_m":-5}}"#,
        422,
        "/camera/orthographic_height_m",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"off_axis":[1,-1,-1,1]}}"#,
        422,
        "/camera/off_axis/0",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"off_axis":[-1,1,1,1]}}"#,
        422,
        "/camera/off_axis/2",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"view_projection":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]}}"#,
        422,
        "/camera/view_projection",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"far_dist_m":-1}}"#,
        422,
        "/lod/far_dist_m",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"dist_factor":0.99}}"#,
        422,
        "/lod/dist_factor",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"levels":0}}"#,
        422,
        "/lod/levels",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"error"}}"#,
        422,
        "/lod/max_error_px",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"error","max_error_px":-2}}"#,
        422,
        "/lod/max_error_px",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"budget"}}"#,
        422,
        "/lod/max_objects",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"max_error_px":2}}"#,
        422,
        "/lod/max_error_px",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"error","max_error_px":2,"far_dist_m":null}}"#,
        422,
        "/lod/far_dist_m",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"budget","max_objects":5,"levels":4}}"#,
        422,
        "/lod/levels",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"budget","max_objects":5,"max_error_px":1}}"#,
        422,
        "/lod/max_error_px",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"effects":{"motion":{"speed_mps":20}}}"#,
        422,
        "/effects/motion",
    ),
];

/// Query, status, parameter.
const QUERIES: &[(&str, u16, &str)] = &[
    ("", 400, "eye"),
    ("target=0,0,0", 400, "eye"),
    ("eye=0,0,1", 422, "target"),
    ("eye=0,0&target=0,0,0", 400, "eye"),
    ("eye=0,0,1,2&target=0,0,0", 400, "eye"),
    ("eye=0,NaN,1&target=0,0,0", 400, "eye"),
    ("eye=0,1e999,1&target=0,0,0", 400, "eye"),
    ("eye=0,inf,1&target=0,0,0", 400, "eye"),
    ("eye=0,,1&target=0,0,0", 400, "eye"),
    ("eye=0,-9,1&target=0,0,0&eye=0,0,2", 400, "eye"),
    ("eye=0,-9,1&target=0,0,0&fov=60", 400, "fov"),
    ("eye=0,-9,1&target=0,0,0&fov_y_deg=wide", 400, "fov_y_deg"),
    ("eye=0,-9,1&target=0,0,0&fov_y_deg=180", 422, "fov_y_deg"),
    ("eye=0,-9,1&target=0,0,0&viewport=1920", 400, "viewport"),
    ("eye=0,-9,1&target=0,0,0&viewport=1920x-1", 400, "viewport"),
    (
        "eye=0,-9,1&target=0,0,0&off_axis=1,-1,-1,1",
        422,
        "off_axis",
    ),
    (
        "eye=0,-9,1&target=0,0,0&quaternion=0,0,0,1",
        422,
        "quaternion",
    ),
    ("eye=0,-9,1&target=0,0,0&mode=best", 400, "mode"),
    ("eye=0,-9,1&target=0,0,0&mode=error", 422, "max_error_px"),
    (
        "eye=0,-9,1&target=0,0,0&mode=error&max_error_px=-1",
        422,
        "max_error_px",
    ),
    (
        "eye=0,-9,1&target=0,0,0&mode=error&max_error_px=inf",
        400,
        "max_error_px",
    ),
    ("eye=0,-9,1&target=0,0,0&mode=budget", 422, "max_objects"),
    (
        "eye=0,-9,1&target=0,0,0&mode=budget&max_objects=5&beyond=hide",
        422,
        "beyond",
    ),
    ("eye=0,-9,1&target=0,0,0&max_objects=5", 422, "max_objects"),
    ("eye=0,-9,1&target=0,0,0&levels=0", 422, "levels"),
    ("eye=0,-9,1&target=0,0,0&levels=two", 400, "levels"),
    ("eye=0,-9,1&target=0,0,0&form=", 400, "form"),
];

#[test]
fn malformed_requests_name_the_member_at_fault() {
    let service = Running::new();
    let mut wrong = Vec::new();
    let mut check = |what: &str, reply: super::server::Reply, status: u16, pointer: &str| {
        let document = reply.json();
        let found = (
            reply.status,
            document["pointer"].as_str().map(str::to_owned),
        );
        if found == (status, Some(pointer.to_owned())) {
            reply.problem(status);
        } else {
            wrong.push(format!(
                "{what}\n  expected {status} {pointer}, got {document}"
            ));
        }
    };
    for &(body, status, pointer) in BODIES {
        check(body, service.visible("demo", body), status, pointer);
    }
    for &(query, status, parameter) in QUERIES {
        let path = format!("/collections/demo/visible?{query}");
        check(query, service.get(&path), status, parameter);
    }
    for (query, status, parameter) in [
        ("start=-1", 400, "start"),
        ("start=x", 400, "start"),
        ("start=3001", 422, "start"),
        ("end=3001", 422, "end"),
        ("start=20&end=10", 422, "end"),
        ("start=1&start=2", 400, "start"),
        ("from=1", 400, "from"),
    ] {
        for what in ["boxes", "items"] {
            let path = format!("/collections/demo/{what}?{query}");
            check(query, service.get(&path), status, parameter);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // After all that it still answers.
    assert_eq!(service.get("/health").json()["status"], "ok");
}

#[test]
fn what_is_not_json_is_located_by_line_and_column() {
    let service = Running::new();
    let body = "{\n  \"camera\": {\n    \"eye\": [0, 0, oops]\n  }\n}";
    let document = service.visible("demo", body).problem(400);
    assert_eq!(document["line"], 3);
    assert!((18..=20).contains(&document["column"].as_u64().unwrap()));
    assert_eq!(document["pointer"], "/camera/eye/2");
}

/// Body, detail.
const DETAILS: &[(&str, &str)] = &[
    (
        r#"{"camera":{"eye":"north at line 1"}}"#,
        "camera.eye must be a list of 3 numbers, and is the text \"north at line 1\"",
    ),
    (
        r#"{"cam at line 1 column 2":1}"#,
        "the body has no member cam at line 1 column 2; it has camera, lod, effects, feedback, output",
    ),
    (
        r#"{"camera":{"eye":[0,0,1]},"lod":{"mode":"far at line 9"}}"#,
        "lod.mode must be one of range, error, budget, and is \"far at line 9\"",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[0,0,0]}"#,
        "the body ends before all that was opened is closed",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"tar"#,
        "at camera: the body ends before all that was opened is closed",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"target":[0,0,0]}} {}"#,
        "more follows where the body should end; send one JSON object",
    ),
    (
        "{'camera':{}}",
        "a name of a member must stand in double quotation marks",
    ),
    (
        r#"{"camera":{"eye":[NaN,0,1]}}"#,
        "at camera.eye[0]: this is no value of JSON, which are numbers, texts in double quotation marks, lists, objects, true, false and null",
    ),
    (
        r#"{"camera":{"eye":[0,0,01]}}"#,
        "at camera.eye[2]: this is no number of JSON: such as 12, -0.5 or 6e3, without zeros or a plus before it",
    ),
    (
        r#"{"camera":{"eye":[0,1e999,1]}}"#,
        "at camera.eye[1]: the number is too large; numbers may reach to 1.7e308",
    ),
    (
        r#"{"camera":{"eye":[0,0,1] "target":[0,0,0]}}"#,
        "at camera: a comma or a closing brace must follow",
    ),
    (
        r#"{"camera":{"eye":[0,0,1,]}}"#,
        "at camera.eye: a comma must be followed by something",
    ),
    (
        r#"{"camera":"\ud83c"}"#,
        "at camera: a text has one half of a character behind \\u; write both halves, such as \\ud83c\\udfe0, or the character itself",
    ),
    (
        r#"{"camera":"\ud83c\u0041"}"#,
        "at camera: a text has one half of a character behind \\u; write both halves, such as \\ud83c\\udfe0, or the character itself",
    ),
    ("null", "the body must be an object, and is null"),
    (
        r#""camera""#,
        "the body must be an object, and is the text \"camera\"",
    ),
    (
        r#"{"camera":[0,0,1]}"#,
        "camera must be an object, and is a list",
    ),
    (
        r#"{"camera":{"eye":[0,"1",1]}}"#,
        "camera.eye[1] must be a number, and is the text \"1\"",
    ),
    (
        r#"{"camera":{"eye":[0,null,1]}}"#,
        "camera.eye[1] must be a number, and is null",
    ),
    (
        r#"{"camera":{"eye":{"x":0}}}"#,
        "camera.eye must be a list of 3 numbers, and is an object",
    ),
    (
        r#"{"camera":{"eye":[0,0]}}"#,
        "camera.eye must be a list of 3 numbers, and has 2",
    ),
    (
        r#"{"camera":{"eye":[0,0,0,1]}}"#,
        "camera.eye must be a list of 3 numbers, and has 4",
    ),
    (
        r#"{"camera":{"eye":[0,0,1],"viewport":[1920.5,1080]}}"#,
        "camera.viewport[0] must be a whole number from 0 to 4294967295, and is 1920.5",
    ),
    ("{}", "camera is missing"),
    (r#"{"camera":{"target":[0,0,0]}}"#, "camera.eye is missing"),
    (
        r#"{"camera":{"eye":[0,0,1],"eye":[0,0,2]}}"#,
        "camera.eye is given twice",
    ),
    (
        r#"{"cam":1}"#,
        "the body has no member cam; it has camera, lod, effects, feedback, output",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"output":{"xml":1}}"#,
        "output has no member xml; it has form",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":"errors"}}"#,
        "lod.mode must be one of range, error, budget, and is \"errors\"",
    ),
    (
        r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]},"lod":{"mode":true}}"#,
        "lod.mode must be one of range, error, budget, and is true",
    ),
];

#[test]
fn what_is_wrong_is_told_in_words_for_who_wrote_it() {
    let service = Running::new();
    for &(body, detail) in DETAILS {
        let problem = service.visible("demo", body).problem(400);
        assert_eq!(problem["detail"], detail, "{body}");
    }
    // Words of the parser, and of the language that it is written in.
    let jargon = [
        "f64",
        "u32",
        "struct",
        "field",
        "variant",
        "invalid type",
        "invalid value",
        "invalid length",
        "EOF",
        "ident",
        "sequence",
        "map",
        "trailing",
        "surrogate",
        "hex escape",
    ];
    for &(body, status, pointer) in BODIES.iter().filter(|(_, status, _)| *status == 400) {
        let problem = service.visible("demo", body).problem(status);
        let detail = problem["detail"].as_str().unwrap();
        for word in jargon {
            assert!(!detail.contains(word), "{body}: {detail}");
        }
        let mut names = pointer
            .split('/')
            .filter(|name| name.parse::<u32>().is_err());
        let name = names.next_back().unwrap_or_default();
        let name = name.replace("~1", "/").replace("~0", "~");
        assert!(
            detail.contains(&name),
            "{body}: {name:?} is not in {detail}"
        );
    }
}

#[test]
fn deep_nesting_is_refused() {
    let service = Running::new();
    for open in ["[", "{\"camera\":", "{\"effects\":{\"a\":"] {
        service.visible("demo", &open.repeat(3_000)).problem(400);
    }
    let effects = format!(
        r#"{{"camera":{{"eye":[0,-9,1],"target":[0,0,0]}},"effects":{{"a":{}{}}}}}"#,
        "[".repeat(10_000),
        "]".repeat(10_000)
    );
    // Passed over without recursion, whatever it holds.
    let document = service.visible("demo", &effects).problem(422);
    assert_eq!(document["pointer"], "/effects/a");
}

#[test]
fn whole_numbers_may_be_written_with_a_point() {
    let service = Running::new();
    let body = r#"{"camera":{"eye":[0,-9,1],"target":[0,0,0],"viewport":[1920.0,1.08e3]},"lod":{"levels":4.0}}"#;
    assert_eq!(service.visible("demo", body).status, 200);
}

#[test]
fn addresses_that_lead_nowhere_get_problem_documents() {
    let service = Running::new();
    let camera = br#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]}}"#;
    let json = [("Content-Type", "application/json")];
    for path in [
        "/nowhere",
        "/collections/",
        "/collections/demo/",
        "/collections/demo/items/",
        "/collections/atlantis/items",
        "/collections/atlantis",
        "/collections/atlantis/boxes",
        "/collections/atlantis/plan.svg",
        "/collections/atlantis/items/b-0000001",
        "/collections/atlantis/visible?eye=0,-9,1&target=0,0,0",
        "/collections/demo/items/b-9999999",
        "/collections/demo/items/%E6%9D%B1",
        "/collections/demo/items/%FF",
        "/collections/%FF",
        "/collections/demo%00",
    ] {
        service.get(path).problem(404);
    }
    let reply = service.send("POST", "/collections/atlantis/visible", &json, camera);
    assert_eq!(reply.problem(404)["pointer"], "scene");
    let reply = service.get("/collections/demo/items/b-9999999");
    assert_eq!(reply.problem(404)["pointer"], "id");
}

#[test]
fn other_methods_are_told_which_there_are() {
    let service = Running::new();
    for (method, path, allowed) in [
        ("POST", "/", "GET,HEAD"),
        ("DELETE", "/collections", "GET,HEAD"),
        ("PUT", "/collections/demo", "GET,HEAD"),
        ("PATCH", "/collections/demo/visible", "GET,HEAD,POST"),
        ("DELETE", "/collections/demo/items/b-0000001", "GET,HEAD"),
        ("OPTIONS", "/collections/demo/boxes", "GET,HEAD"),
        ("BREW", "/health", "GET,HEAD"),
    ] {
        let reply = service.send(method, path, &[], b"");
        reply.problem(405);
        let mut allow: Vec<&str> = reply.header("allow").unwrap().split(',').collect();
        allow.sort_unstable();
        assert_eq!(allow.join(","), allowed, "{method} {path}");
    }
}

#[test]
fn bodies_of_other_types_are_refused() {
    let service = Running::new();
    let camera = br#"{"camera":{"eye":[0,-9,1],"target":[0,0,0]}}"#;
    let path = "/collections/demo/visible";
    for (content_type, status) in [
        ("application/json", 200),
        ("application/json; charset=utf-8", 200),
        ("Application/JSON", 200),
        ("application/x-www-form-urlencoded", 415),
        ("text/plain", 415),
        ("application/jsonx", 415),
        ("multipart/form-data; boundary=x", 415),
    ] {
        let reply = service.send("POST", path, &[("Content-Type", content_type)], camera);
        assert_eq!(reply.status, status, "{content_type}");
        if status == 415 {
            assert_eq!(reply.problem(415)["pointer"], "Content-Type");
        }
    }
    assert_eq!(service.send("POST", path, &[], camera).status, 200);
}
