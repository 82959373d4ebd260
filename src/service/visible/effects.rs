//! What a request asks of the effects that its scene declares: nothing said leaves them on,
//! `false` switches one off.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::super::json::{Whole, given, keyword};
use super::super::problem::{Kind, Problem};
use super::query::Parameter;
use super::resolve::Naming;
use super::undeclared::undeclared;
use crate::frame::Active;
use crate::scene::{self, Criterion};

/// `max_error_px` of terrain in a query, where the name alone is that of error mode.
const GROUND_ERROR_PX: &str = "ground_error_px";

/// The `effects` of a request.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Effects {
    pub motion: Asked<Motion>,
    pub haze: Asked<Haze>,
    pub occlusion: Asked<Occlusion>,
    pub terrain: Asked<Terrain>,
    /// A name that no effect has.
    pub unknown: Option<String>,
}

/// What is said of one effect.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Asked<T> {
    /// Nothing: it is on if it is declared.
    #[default]
    Unsaid,
    /// `false`.
    Off,
    /// `true`, or an object of settings.
    On(T),
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Motion {
    pub speed_mps: f64,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Haze {}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Occlusion {
    #[serde(deserialize_with = "given")]
    pub width_px: Option<Whole>,
    #[serde(deserialize_with = "given")]
    pub min_pixels: Option<Whole>,
    pub visible_pixels: bool,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Terrain {
    #[serde(deserialize_with = "criterion")]
    pub criterion: Option<Criterion>,
    #[serde(deserialize_with = "given")]
    pub max_error_px: Option<f64>,
    #[serde(deserialize_with = "given")]
    pub max_triangles: Option<Whole>,
    pub patches: bool,
}

fn criterion<'de, D: Deserializer<'de>>(source: D) -> Result<Option<Criterion>, D::Error> {
    keyword(source, &Criterion::NAMES, &Criterion::VALUES).map(Some)
}

impl Effects {
    /// Takes a parameter of a query; `false` where it is none of an effect.
    ///
    /// # Errors
    /// 400 that names the parameter, 422 where two contradict each other.
    pub fn take(&mut self, parameter: &Parameter) -> Result<bool, Problem> {
        match parameter.name {
            "speed_mps" => {
                let speed = parameter.number()?;
                self.motion
                    .set(parameter, |motion| motion.speed_mps = speed)?;
            }
            "width_px" => {
                let width = parameter.whole(parameter.text)?;
                self.occlusion
                    .set(parameter, |occlusion| occlusion.width_px = Some(width))?;
            }
            "min_pixels" => {
                let least = parameter.whole(parameter.text)?;
                self.occlusion
                    .set(parameter, |occlusion| occlusion.min_pixels = Some(least))?;
            }
            "visible_pixels" => {
                let listed = parameter.word(&["true", "false"], &[true, false])?;
                self.occlusion
                    .set(parameter, |occlusion| occlusion.visible_pixels = listed)?;
            }
            "criterion" => {
                let word = parameter.word(&Criterion::NAMES, &Criterion::VALUES)?;
                self.terrain
                    .set(parameter, |terrain| terrain.criterion = Some(word))?;
            }
            GROUND_ERROR_PX => {
                let px = parameter.number()?;
                self.terrain
                    .set(parameter, |terrain| terrain.max_error_px = Some(px))?;
            }
            "max_triangles" => {
                let most = parameter.whole(parameter.text)?;
                self.terrain
                    .set(parameter, |terrain| terrain.max_triangles = Some(most))?;
            }
            "patches" => {
                let listed = parameter.word(&["true", "false"], &[true, false])?;
                self.terrain
                    .set(parameter, |terrain| terrain.patches = listed)?;
            }
            "without" => {
                for name in parameter.text.split(',') {
                    match name {
                        "motion" => self.motion.switch_off(parameter)?,
                        "haze" => self.haze.switch_off(parameter)?,
                        "occlusion" => self.occlusion.switch_off(parameter)?,
                        "terrain" => self.terrain.switch_off(parameter)?,
                        _ => {
                            let detail = format!(
                                "must be motion, haze, occlusion or terrain, or several with \
                                 commas, is {name:?}"
                            );
                            return Err(parameter.problem(detail));
                        }
                    }
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// The effects of the frame, of those that the scene declares.
    ///
    /// # Errors
    /// 422 for one that it does not declare, and for settings that cannot be.
    pub fn active(&self, declared: &scene::Effects, naming: Naming) -> Result<Active, Problem> {
        if let Some(name) = &self.unknown {
            return Err(undeclared(name, name, declared, naming));
        }
        let refused = |name, parameter| undeclared(name, parameter, declared, naming);
        Ok(Active {
            motion: self.motion.of(
                declared.motion,
                |_| refused("motion", "speed_mps"),
                |on, said| {
                    let speed = said.speed_mps;
                    if speed >= 0.0 && speed.is_finite() {
                        return Ok((on, speed));
                    }
                    let detail = format!("must be 0 or more and finite, is {speed}");
                    Err(naming.setting("motion/speed_mps", detail))
                },
            )?,
            haze: self
                .haze
                .of(declared.haze, |_| refused("haze", "haze"), |on, _| Ok(on))?,
            occlusion: self.occlusion.of(
                declared.occlusion,
                |said| refused("occlusion", said.parameter()),
                |on, said| said.over(on, naming),
            )?,
            terrain: self.terrain.of(
                declared.terrain,
                |said| refused("terrain", said.parameter()),
                |on, said| said.over(on, naming),
            )?,
            ..Active::default()
        })
    }

    /// Whether the answer is to list the patches of the ground.
    pub fn patches(&self) -> bool {
        matches!(self.terrain, Asked::On(said) if said.patches)
    }

    /// Whether the answer is to carry the pixels of each object.
    pub fn visible_pixels(&self) -> bool {
        matches!(self.occlusion, Asked::On(said) if said.visible_pixels)
    }
}

impl<T: Copy + Default> Asked<T> {
    /// Asks for the effect with a setting changed; 422 where it is switched off.
    fn set(&mut self, by: &Parameter, change: impl FnOnce(&mut T)) -> Result<(), Problem> {
        let mut settings = match self {
            Self::On(settings) => *settings,
            Self::Unsaid => T::default(),
            Self::Off => {
                let detail = "is of an effect that `without` switches off";
                return Err(Problem::new(Kind::ImpossibleValue, detail).at(by.name));
            }
        };
        change(&mut settings);
        *self = Self::On(settings);
        Ok(())
    }

    /// Switches the effect off; 422 where it is asked for.
    fn switch_off(&mut self, by: &Parameter) -> Result<(), Problem> {
        if matches!(self, Self::On(_)) {
            let detail = "switches off an effect that another parameter asks for";
            return Err(Problem::new(Kind::ImpossibleValue, detail).at(by.name));
        }
        *self = Self::Off;
        Ok(())
    }

    fn of<D, A>(
        &self,
        declared: Option<D>,
        refused: impl FnOnce(&T) -> Problem,
        settled: impl FnOnce(D, T) -> Result<A, Problem>,
    ) -> Result<Option<A>, Problem> {
        match (self, declared) {
            (Self::Off, _) | (Self::Unsaid, None) => Ok(None),
            (Self::On(said), None) => Err(refused(said)),
            (Self::Unsaid, Some(declared)) => settled(declared, T::default()).map(Some),
            (Self::On(said), Some(declared)) => settled(declared, *said).map(Some),
        }
    }
}

impl Occlusion {
    /// The parameter that asks for it.
    fn parameter(&self) -> &'static str {
        match (self.width_px, self.min_pixels) {
            (Some(_), _) => "width_px",
            (None, Some(_)) => "min_pixels",
            (None, None) => "visible_pixels",
        }
    }

    /// The declared settings with those of the request in their place.
    fn over(self, declared: scene::Occlusion, naming: Naming) -> Result<scene::Occlusion, Problem> {
        let occlusion = scene::Occlusion {
            width_px: self.width_px.map_or(declared.width_px, |w| w.0),
            min_pixels: self.min_pixels.map_or(declared.min_pixels, |m| m.0),
        };
        if occlusion.width_px > declared.width_px {
            let most = declared.width_px;
            let detail = format!("must be at most {most}, the width that the scene declares");
            return Err(naming.setting("occlusion/width_px", detail));
        }
        let effects = scene::Effects {
            occlusion: Some(occlusion),
            ..scene::Effects::default()
        };
        effects.check().map_err(|error| {
            let member = error.pointer.unwrap_or_default().trim_start_matches('/');
            naming.setting(member, error.reason)
        })?;
        Ok(occlusion)
    }
}

impl Terrain {
    /// The parameter that asks for it.
    fn parameter(&self) -> &'static str {
        match (self.criterion, self.max_error_px, self.max_triangles) {
            (Some(_), ..) => "criterion",
            (None, Some(_), _) => GROUND_ERROR_PX,
            (None, None, Some(_)) => "max_triangles",
            (None, None, None) => "patches",
        }
    }

    /// The declared settings with those of the request in their place.
    fn over(self, declared: scene::Terrain, naming: Naming) -> Result<scene::Terrain, Problem> {
        let terrain = scene::Terrain {
            criterion: self.criterion.unwrap_or(declared.criterion),
            max_error_px: self.max_error_px.unwrap_or(declared.max_error_px),
            max_triangles: self.max_triangles.map_or(declared.max_triangles, |m| m.0),
            ..declared
        };
        let refused = |member: &str, detail: String| match naming {
            Naming::Parameter if member == "terrain/max_error_px" => {
                Err(naming.problem("effects", GROUND_ERROR_PX, detail))
            }
            _ => Err(naming.setting(member, detail)),
        };
        let effects = scene::Effects {
            terrain: Some(terrain),
            ..scene::Effects::default()
        };
        if let Err(error) = effects.check() {
            let member = error.pointer.unwrap_or_default().trim_start_matches('/');
            return refused(member, error.reason);
        }
        if terrain.max_error_px < declared.max_error_px {
            let least = declared.max_error_px;
            let detail = format!("must be at least {least}, which the scene declares");
            return refused("terrain/max_error_px", detail);
        }
        if terrain.max_triangles > declared.max_triangles {
            let most = declared.max_triangles;
            let detail = format!("must be at most {most}, which the scene declares");
            return refused("terrain/max_triangles", detail);
        }
        Ok(terrain)
    }
}

impl<'de> Deserialize<'de> for Effects {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Members;
        impl<'de> Visitor<'de> for Members {
            type Value = Effects;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Effects, A::Error> {
                let mut effects = Effects::default();
                while let Some(name) = map.next_key::<String>()? {
                    match name.as_str() {
                        "motion" => effects.motion = map.next_value()?,
                        "haze" => effects.haze = map.next_value()?,
                        "occlusion" => effects.occlusion = map.next_value()?,
                        "terrain" => effects.terrain = map.next_value()?,
                        _ => {
                            map.next_value::<IgnoredAny>()?;
                            effects.unknown = Some(name);
                        }
                    }
                }
                Ok(effects)
            }
        }
        source.deserialize_map(Members)
    }
}

impl<'de, T: Deserialize<'de> + Default> Deserialize<'de> for Asked<T> {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Setting<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de> + Default> Visitor<'de> for Setting<T> {
            type Value = Asked<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("true, false or an object of settings")
            }
            fn visit_bool<E>(self, on: bool) -> Result<Asked<T>, E> {
                Ok(if on {
                    Asked::On(T::default())
                } else {
                    Asked::Off
                })
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Asked<T>, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(Asked::On)
            }
        }
        source.deserialize_any(Setting(PhantomData))
    }
}
