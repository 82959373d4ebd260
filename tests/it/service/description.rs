use std::collections::BTreeSet;

use citylod::service::{OPENAPI, ROUTES};
use serde_json::Value;

use super::server::Running;
use super::stream_client::Client;

fn description() -> Value {
    serde_saphyr::from_str(OPENAPI).unwrap()
}

const METHODS: [&str; 8] = [
    "get", "put", "post", "delete", "options", "head", "patch", "trace",
];

fn operations(description: &Value) -> Vec<(String, String, &Value)> {
    let paths = description["paths"].as_object().unwrap();
    let mut operations = Vec::new();
    for (path, item) in paths {
        for (method, operation) in item.as_object().unwrap() {
            if METHODS.contains(&method.as_str()) {
                operations.push((method.to_uppercase(), path.clone(), operation));
            }
        }
    }
    operations
}

#[test]
fn the_description_and_the_routes_agree() {
    let description = description();
    let described: BTreeSet<(String, String)> = operations(&description)
        .into_iter()
        .map(|(method, path, _)| (method, path))
        .collect();
    let routed: BTreeSet<(String, String)> = ROUTES
        .iter()
        .map(|route| (route.verb.name().to_owned(), route.path.to_owned()))
        .collect();
    assert_eq!(described, routed);
    assert_eq!(
        description["info"]["version"],
        env!("CARGO_PKG_VERSION"),
        "of description and package"
    );
}

#[test]
fn the_description_is_served_as_it_is() {
    let reply = Running::new().get("/api");
    assert_eq!(String::from_utf8(reply.body).unwrap(), OPENAPI);
}

#[test]
fn a_parameter_that_there_is_not_is_refused_with_those_there_are() {
    let description = description();
    let visible = &description["paths"]["/collections/{scene}/visible"]["get"];
    let described = visible["parameters"].as_array().unwrap().iter();
    let names: Vec<&str> = described
        .map(|parameter| match parameter["$ref"].as_str() {
            Some(place) => description.pointer(&place[1..]).unwrap(),
            None => parameter,
        })
        .filter(|parameter| parameter["in"] == "query")
        .map(|parameter| parameter["name"].as_str().unwrap())
        .collect();
    let service = Running::new();
    let detail = |query: &str| {
        let reply = service.get(&format!("/collections/demo/visible?{query}"));
        assert_eq!(reply.status, 400, "{query}");
        reply.json()["detail"].as_str().unwrap().to_owned()
    };
    let all = detail("eye=0,0,0&target=0,1,0&xyz=1");
    let all = all
        .strip_prefix("there is no such parameter, only ")
        .unwrap();
    assert_eq!(all.split(", ").collect::<Vec<_>>(), names);
    for name in names {
        let twice = detail(&format!("{name}=&{name}="));
        assert!(!twice.contains("no such parameter"), "{name}: {twice}");
    }
    for (typed, meant) in [
        ("far_dist", "far_dist_m?"),
        ("error_px", "max_error_px or ground_error_px?"),
        ("maxObjects", "max_objects?"),
        ("targets", "target?"),
        ("fov", "fov_y_deg?"),
    ] {
        let told = detail(&format!("{typed}=1"));
        assert!(told.ends_with(&format!("did you mean {meant}")), "{told}");
    }
    let of_span = service.get("/collections/demo/items?from=3").json();
    assert!(
        of_span["detail"]
            .as_str()
            .unwrap()
            .ends_with("only start, end, revision")
    );
}

#[test]
fn every_reference_in_the_description_leads_somewhere() {
    fn walk<'a>(value: &'a Value, found: &mut Vec<&'a str>) {
        match value {
            Value::Object(members) => {
                found.extend(members.get("$ref").and_then(Value::as_str));
                members.values().for_each(|v| walk(v, found));
            }
            Value::Array(items) => items.iter().for_each(|v| walk(v, found)),
            _ => {}
        }
    }
    let description = description();
    let mut references = Vec::new();
    walk(&description, &mut references);
    assert!(references.len() > 50);
    for reference in references {
        let pointer = reference.strip_prefix('#').unwrap();
        assert!(description.pointer(pointer).is_some(), "{reference}");
    }
}

#[test]
fn every_example_in_the_description_works() {
    let service = Running::new();
    let description = description();
    let mut tried = 0;
    for (method, path, operation) in operations(&description) {
        let path = path.replace("{scene}", "demo");
        if method == "POST" {
            let content = &operation["requestBody"]["content"]["application/json"];
            for (name, example) in content["examples"].as_object().unwrap() {
                let body = example["value"].to_string();
                let reply = service.send(
                    "POST",
                    &path,
                    &[("Content-Type", "application/json")],
                    body.as_bytes(),
                );
                let text = String::from_utf8_lossy(&reply.body);
                assert_eq!(reply.status, 200, "{name}: {text}");
                assert!(
                    reply.json()["count"].as_u64() > Some(0),
                    "{name} shows nothing"
                );
                tried += 1;
            }
        } else if let Some(parameters) = operation["parameters"].as_array() {
            let query: Vec<String> = parameters
                .iter()
                .filter(|parameter| !parameter["example"].is_null())
                .map(|parameter| {
                    let value = match &parameter["example"] {
                        Value::Array(items) => {
                            let items: Vec<String> = items.iter().map(Value::to_string).collect();
                            items.join(",")
                        }
                        Value::String(text) => text.clone(),
                        other => other.to_string(),
                    };
                    format!("{}={value}", parameter["name"].as_str().unwrap())
                })
                .collect();
            let reply = service.get(&format!("{path}?{}", query.join("&")));
            assert_eq!(reply.status, 200, "{path}");
            tried += 1;
        }
    }
    assert!(tried >= 9, "{tried} examples");
}

#[test]
fn every_message_in_the_description_works_and_its_answer_has_the_members_described() {
    let service = Running::new();
    let description = description();
    let schemas = &description["components"]["schemas"];
    let members = |schema: &str, part: &str| -> BTreeSet<String> {
        match &schemas[schema][part] {
            Value::Array(names) => names
                .iter()
                .map(|name| name.as_str().unwrap().to_owned())
                .collect(),
            properties => properties.as_object().unwrap().keys().cloned().collect(),
        }
    };
    let named = |document: &Value| -> BTreeSet<String> {
        document.as_object().unwrap().keys().cloned().collect()
    };
    let mut client = Client::open(&service, "demo");
    let examples = schemas["StreamMessage"]["examples"].as_array().unwrap();
    assert!(examples.len() >= 4);
    let (required, known) = (
        members("StreamAnswer", "required"),
        members("StreamAnswer", "properties"),
    );
    let mut met = BTreeSet::new();
    for example in examples {
        client.send_text(&example.to_string());
        client.receive();
        let answer: Value = serde_json::from_str(client.last()).unwrap();
        met.extend(named(&answer));
        assert_eq!(answer["seq"], example["seq"], "{answer}");
        assert!(named(&answer).is_superset(&required), "{answer}");
        assert!(named(&answer).is_subset(&known), "{answer}");
        assert!(
            answer["count"].as_u64() > Some(0),
            "{example} shows nothing"
        );
    }
    assert_eq!(met, known);
    client.send_text("{}");
    let refusal = named(&client.receive());
    assert_eq!(refusal, members("StreamRefusal", "required"));
}
