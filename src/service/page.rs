//! The page at `/about`, filled in from `page.html`.

use std::fmt::Write as _;

use super::curl;
use super::problem::Kind;
use super::routes::ROUTES;
use super::scenes::{City, Scenes};

const TEMPLATE: &str = include_str!("page.html");

/// Whether this build has the viewer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Viewer {
    /// At `/`.
    There,
    /// Built without Node.js.
    Missing,
}

/// The page for these scenes; `host` is how the reader reaches the service.
pub fn render(scenes: &Scenes, host: &str, viewer: Viewer) -> String {
    let cards: String = scenes.iter().map(|city| card(city)).collect();
    let cards = if scenes.is_empty() {
        "<p>No scene is being served.</p>".to_owned()
    } else {
        cards
    };
    let base = format!("http://{host}");
    let command = scenes.iter().next().map_or_else(
        || format!("curl -s {base}/collections"),
        |city| curl(&base, &city.path(), &city.example_request()),
    );
    let notice = match viewer {
        Viewer::There => "",
        Viewer::Missing => {
            "<p class=\"notice\">This build has no viewer: Node.js was not at hand when it was made. \
             <code>make run</code> with Node.js 20.19 or newer builds it, and shows the city here.</p>"
        }
    };
    let fly = match viewer {
        Viewer::There => "<a href=\"/\">Fly through the city</a>",
        Viewer::Missing => "",
    };
    TEMPLATE
        .replace("{{notice}}", notice)
        .replace("{{fly}}", fly)
        .replace("{{cards}}", &cards)
        .replace("{{curl}}", &escape(&command))
        .replace("{{routes}}", &routes())
        .replace("{{problems}}", &problems())
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
}

fn card(city: &City) -> String {
    let tree = city.tree();
    let (name, path) = (escape(city.name()), city.path());
    let bounds = tree.bounds();
    let extent = if bounds.is_empty() {
        "empty".to_owned()
    } else {
        let size = bounds.size();
        format!(
            "{} × {}, up to {:.0} m high",
            length(size.x),
            length(size.y),
            size.z
        )
    };
    let classes = tree.classes().iter().take(6).map(AsRef::as_ref);
    let classes: Vec<&str> = classes.collect();
    let crs = tree.crs().map_or_else(|| "local".to_owned(), escape);
    format!(
        "<article class=\"card\"><a class=\"plan\" href=\"{path}/plan.svg\">\
         <img src=\"{path}/plan.svg\" alt=\"{name} from above, coloured by height\"></a>\
         <div class=\"facts\"><h3><a href=\"{path}\">{name}</a></h3><dl>\
         <dt>Objects</dt><dd>{objects}</dd><dt>Levels</dt><dd>{levels}</dd>\
         <dt>Extent</dt><dd>{extent}</dd><dt>Classes</dt><dd>{classes}</dd>\
         <dt>Coordinates</dt><dd>{crs}</dd><dt>Revision</dt><dd><code>{revision}</code></dd>\
         </dl></div></article>",
        objects = grouped(tree.object_count()),
        levels = tree.level_count(),
        classes = escape(&classes.join(", ")),
        revision = tree.revision(),
    )
}

fn routes() -> String {
    let mut rows = String::new();
    for route in ROUTES {
        let _ = write!(
            rows,
            "<tr><td><span class=\"verb {verb}\">{verb}</span></td><td><code>{path}</code></td><td>{what}</td></tr>",
            verb = route.verb.name(),
            path = route.path,
            what = route.what,
        );
    }
    rows
}

fn problems() -> String {
    let mut rows = String::new();
    for kind in Kind::ALL {
        let (status, slug, title) = kind.parts();
        let _ = write!(
            rows,
            "<tr id=\"{slug}\"><td>{}</td><td><code>/#{slug}</code></td><td>{title}</td></tr>",
            status.as_u16()
        );
    }
    rows
}

fn length(metres: f64) -> String {
    if metres >= 1000.0 {
        format!("{:.1} km", metres / 1000.0)
    } else {
        format!("{metres:.0} m")
    }
}

/// `23951` → `23,951`.
pub fn grouped(number: u32) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}
