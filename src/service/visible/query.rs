//! The same request as query parameters: `eye=1,2,3&target=0,0,0&viewport=1920x1080`.

use std::borrow::Cow;

use super::super::json::{List, Whole};
use super::super::problem::{Kind, Problem};
use super::effects::Effects;
use super::feedback::{self, Feedback};
use super::request::{
    BEYOND_NAMES, BEYOND_VALUES, CULLING_NAMES, CULLING_VALUES, Camera, Form, Lod, Mode, Output,
    Request,
};

/// All parameters there are, in the order of the description of the service.
const PARAMETERS: [&str; 35] = [
    "eye",
    "target",
    "up",
    "quaternion",
    "fov_y_deg",
    "orthographic_height_m",
    "off_axis",
    "view_projection",
    "viewport",
    "near",
    "far",
    "mode",
    "far_dist_m",
    "dist_factor",
    "levels",
    "beyond",
    "culling",
    "max_error_px",
    "max_objects",
    "speed_mps",
    "width_px",
    "min_pixels",
    "visible_pixels",
    "criterion",
    "ground_error_px",
    "max_triangles",
    "patches",
    "without",
    "target_ms",
    "frame_ms",
    "frame_far_dist_m",
    "min_far_dist_m",
    "max_far_dist_m",
    "state",
    "form",
];

/// Reads the query of a URL.
///
/// # Errors
/// 400 with the name of the parameter at fault.
pub fn read(query: &str) -> Result<Request, Problem> {
    let mut camera = Camera::default();
    let mut lod = Lod::default();
    let mut output = Output::default();
    let mut effects = Effects::default();
    let mut feedback: Option<Feedback> = None;
    let mut seen: Vec<Cow<'_, str>> = Vec::new();
    for (name, text) in form_urlencoded::parse(query.as_bytes()) {
        let parameter = Parameter {
            name: &name,
            text: &text,
        };
        match &*name {
            "eye" => camera.eye = parameter.list()?,
            "target" => camera.target = Some(parameter.list()?),
            "up" => camera.up = Some(parameter.list()?),
            "quaternion" => camera.quaternion = Some(parameter.list()?),
            "fov_y_deg" => camera.fov_y_deg = Some(parameter.number()?),
            "orthographic_height_m" => camera.orthographic_height_m = Some(parameter.number()?),
            "off_axis" => camera.off_axis = Some(parameter.list()?),
            "view_projection" => camera.view_projection = Some(parameter.list()?),
            "viewport" => camera.viewport = Some(parameter.sides()?),
            "near" => camera.near = Some(parameter.number()?),
            "far" => camera.far = Some(parameter.number_or_null()?),
            "mode" => lod.mode = parameter.word(&Mode::NAMES, &Mode::VALUES)?,
            "far_dist_m" => lod.far_dist_m = Some(parameter.number_or_null()?),
            "dist_factor" => lod.dist_factor = Some(parameter.number()?),
            "levels" => lod.levels = Some(parameter.whole(&text)?),
            "beyond" => lod.beyond = Some(parameter.word(&BEYOND_NAMES, &BEYOND_VALUES)?),
            "max_error_px" => lod.max_error_px = Some(parameter.number()?),
            "max_objects" => lod.max_objects = Some(parameter.whole(&text)?),
            "culling" => lod.culling = parameter.word(&CULLING_NAMES, &CULLING_VALUES)?,
            "form" => output.form = parameter.word(&Form::NAMES, &Form::VALUES)?,
            _ if feedback::take(&mut feedback, &parameter)? => {}
            _ if effects.take(&parameter)? => {}
            _ => return Err(unknown(&name, &PARAMETERS)),
        }
        if seen.contains(&name) {
            return Err(parameter.problem("is given twice"));
        }
        seen.push(name);
    }
    if !seen.iter().any(|name| name == "eye") {
        let detail = "missing: where the view is seen from, eye=x,y,z";
        return Err(Problem::new(Kind::InvalidRequest, detail).at("eye"));
    }
    if feedback.is_some() && !seen.iter().any(|name| name == "target_ms") {
        let detail = "missing: the frame time to hold, ms";
        return Err(Problem::new(Kind::ImpossibleValue, detail).at("target_ms"));
    }
    Ok(Request {
        camera,
        lod,
        effects,
        feedback,
        output,
    })
}

/// The refusal of a parameter that is none of the `known` ones, with those that are called alike,
/// or else all of them.
pub fn unknown(name: &str, known: &[&str]) -> Problem {
    let alike = alike(name, known);
    let detail = if alike.is_empty() {
        format!("there is no such parameter, only {}", known.join(", "))
    } else {
        let meant = alike.join(" or ");
        format!("there is no such parameter; did you mean {meant}?")
    };
    Problem::new(Kind::InvalidRequest, detail).at(name)
}

/// Those that begin with a name, else those that have it in them or are in it.
fn alike<'a>(name: &str, known: &[&'a str]) -> Vec<&'a str> {
    /// Shorter ones are in many names by chance.
    const SHORTEST: usize = 3;
    let plain = |name: &str| name.to_lowercase().replace(['_', '-'], "");
    let given = plain(name);
    let those = |holds: &dyn Fn(&str) -> bool| -> Vec<&'a str> {
        let known = known.iter().copied();
        known.filter(|known| holds(&plain(known))).collect()
    };
    if given.len() < SHORTEST {
        return Vec::new();
    }
    let begin = those(&|known| known.starts_with(&given));
    if !begin.is_empty() {
        return begin;
    }
    those(&|known| known.contains(&given) || known.len() >= SHORTEST && given.contains(known))
}

/// One parameter as it was given.
#[derive(Debug, Clone, Copy)]
pub struct Parameter<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its value.
    pub text: &'a str,
}

impl Parameter<'_> {
    /// A 400 that names the parameter.
    pub fn problem(&self, detail: impl Into<String>) -> Problem {
        Problem::new(Kind::InvalidRequest, detail).at(self.name)
    }

    fn parse(&self, text: &str) -> Result<f64, Problem> {
        let number = text.parse().ok().filter(|n: &f64| n.is_finite());
        number.ok_or_else(|| self.problem(format!("must be a finite number, is {text:?}")))
    }

    pub fn number(&self) -> Result<f64, Problem> {
        self.parse(self.text)
    }

    fn number_or_null(&self) -> Result<Option<f64>, Problem> {
        if self.text == "null" {
            return Ok(None);
        }
        self.number().map(Some)
    }

    /// A whole number of 32 bits.
    ///
    /// # Errors
    /// 400 that names the parameter.
    pub fn whole(&self, text: &str) -> Result<Whole, Problem> {
        let number = self.parse(text)?;
        Whole::new(number).ok_or_else(|| {
            self.problem(format!(
                "must be a whole number from 0 to 4294967295, is {text:?}"
            ))
        })
    }

    fn list<const N: usize>(&self) -> Result<List<f64, N>, Problem> {
        let mut items = [0.0; N];
        let mut texts = self.text.split(',');
        for item in &mut items {
            *item = match texts.next() {
                Some(text) => self.parse(text)?,
                None => return Err(self.wrong_length::<N>()),
            };
        }
        match texts.next() {
            None => Ok(List(items)),
            Some(_) => Err(self.wrong_length::<N>()),
        }
    }

    fn wrong_length<const N: usize>(&self) -> Problem {
        let found = self.text.split(',').count();
        self.problem(format!("must be {N} numbers, is {found}: {:?}", self.text))
    }

    /// `1920x1080` or `1920,1080`.
    fn sides(&self) -> Result<List<Whole, 2>, Problem> {
        let (width, height) = self
            .text
            .split_once(['x', ','])
            .ok_or_else(|| self.problem(format!("must be WIDTHxHEIGHT, is {:?}", self.text)))?;
        Ok(List([self.whole(width)?, self.whole(height)?]))
    }

    pub fn word<T: Copy>(&self, names: &[&str], values: &[T]) -> Result<T, Problem> {
        let at = names.iter().position(|&name| name == self.text);
        at.and_then(|at| values.get(at).copied()).ok_or_else(|| {
            self.problem(format!(
                "must be {}, is {:?}",
                names.join(" or "),
                self.text
            ))
        })
    }
}
