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
    let detail = if effects.iter().all(|(effect, _)| *effect != name) {
        let all = names(|_| true);
        format!(
            "the scene does not declare the effect {name:?}: there is no such effect, only {all}"
        )
    } else {
        let declares = match names(|(_, declared)| *declared) {
            none if none.is_empty() => "nor any other".into(),
            others => format!("only {others}"),
        };
        let how = match name {
            "terrain" => "lay its ground with citylod import ELEVATION --into CITY",
            _ => "declare it with --effects when the city is imported",
        };
        format!(
            "the scene does not declare the effect {name:?}, {declares}; leave {name} out, or {how}"
        )
    };
    match naming {
        Naming::Pointer => naming.problem("effects", &token(name), detail),
        Naming::Parameter => naming.problem("effects", parameter, detail),
    }
}
