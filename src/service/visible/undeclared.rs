//! The refusal of effects that the scene does not declare, with the way out.

use super::super::json::token;
use super::super::problem::Problem;
use super::resolve::Naming;
use crate::scene::Effects;

/// Of the effect `name`, asked for in a query by `parameter`.
pub fn undeclared(name: &str, parameter: &str, declared: &Effects, naming: Naming) -> Problem {
    let effects = [
        ("motion", declared.motion.is_some()),
        ("haze", declared.haze.is_some()),
        ("occlusion", declared.occlusion.is_some()),
        ("terrain", declared.terrain.is_some()),
    ];
    let names = |of: fn(&(&'static str, bool)) -> bool| {
        let names: Vec<&str> = effects.iter().filter(|e| of(e)).map(|e| e.0).collect();
        names.join(", ")
    };
    let way_out = if effects.iter().all(|(effect, _)| *effect != name) {
        format!("there is no such effect, only {}", names(|_| true))
    } else {
        let declares = match names(|(_, declared)| *declared) {
            none if none.is_empty() => "none".into(),
            names => names,
        };
        let how = match name {
            "terrain" => "lay its ground with citylod import ELEVATION --into CITY",
            _ => "import the city with --effects",
        };
        format!("it declares {declares}; leave it out, or {how}")
    };
    let detail = format!("the scene does not declare the effect {name:?}: {way_out}");
    match naming {
        Naming::Pointer => naming.problem("effects", &token(name), detail),
        Naming::Parameter => naming.problem("effects", parameter, detail),
    }
}
