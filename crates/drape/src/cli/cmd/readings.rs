//! Readings of textile instruments for `drape material --reading`.

use super::refusal;
use drape_model::Violation;
use drape_model::fabric::{Material, Woven, units};

/// A reading as the user gives it: `KEY=VALUE` or `KEY=WARP,WEFT`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reading {
    text: String,
    key: &'static Key,
    values: Woven,
}

/// What a reading is called, and what it gives.
#[derive(Debug, PartialEq)]
struct Key {
    name: &'static str,
    unit: &'static str,
    /// The constant of the material that it sets.
    sets: &'static str,
}

const KEYS: [Key; 8] = [
    Key { name: "density", unit: "kg/m²", sets: "areal_density_kg_m2" },
    Key { name: "kes-b", unit: "gf cm²/cm", sets: "bending_n_m" },
    Key { name: "kes-g", unit: "gf/(cm degree)", sets: "shear_n_per_m" },
    Key { name: "kes-emt", unit: "%", sets: "tension_n_per_m" },
    Key { name: "fast-c", unit: "mm", sets: "bending_n_m" },
    Key { name: "fast-e20", unit: "%", sets: "tension_n_per_m" },
    Key { name: "fast-e100", unit: "%", sets: "tension_n_per_m" },
    Key { name: "fast-eb5", unit: "%", sets: "shear_n_per_m" },
];

/// For the help of the option.
pub(crate) const HELP: &str = "A reading of an instrument, which replaces a constant of the \
    material; may be repeated. KEY=VALUE, or KEY=WARP,WEFT: density (kg/m²), kes-b (gf cm²/cm), \
    kes-g (gf/(cm degree)), kes-emt (% at 500 gf/cm), fast-c (bending length, mm), fast-e20 with \
    fast-e100 (%), fast-eb5 (%)";

impl std::str::FromStr for Reading {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = || KEYS.map(|key| key.name).join(", ");
        let (name, values) = text
            .split_once('=')
            .ok_or_else(|| format!("expected KEY=VALUE with one of the keys {}", known()))?;
        let key = KEYS.iter().find(|key| key.name == name.trim());
        let key = key.ok_or_else(|| format!("no reading `{name}`; expected {}", known()))?;
        let number = |word: &str| {
            let value = word.trim().parse::<f64>().ok().filter(|v| *v > 0.0 && v.is_finite());
            value.ok_or_else(|| format!("`{word}`; expected a number above 0, in {}", key.unit))
        };
        let (warp, weft) = values.split_once(',').unwrap_or((values, values));
        let values = Woven { warp: number(warp)?, weft: number(weft)? };
        Ok(Self { text: text.to_owned(), key, values })
    }
}

/// Puts what the readings say in the place of the material's constants.
///
/// # Errors
/// A [`Violation`] at `--reading`: a constant that is set twice, one of two extensions without the
/// other, or a constant out of range.
pub(crate) fn apply(readings: &[Reading], material: &mut Material) -> Result<(), Violation> {
    let refuse = |value: String, expected: &str| refusal("--reading", value, expected);
    let find = |name: &str| readings.iter().find(|reading| reading.key.name == name);
    for (place, reading) in readings.iter().enumerate() {
        let is_pair = |other: &Reading| {
            other.key != reading.key
                && [other, reading]
                    .iter()
                    .all(|r| r.key.name.starts_with("fast-e") && r.key.sets == "tension_n_per_m")
        };
        let earlier = &readings[..place];
        if let Some(other) =
            earlier.iter().find(|other| other.key.sets == reading.key.sets && !is_pair(other))
        {
            let expected = format!("one reading that sets {}", reading.key.sets);
            return Err(refuse(format!("{} beside {}", reading.text, other.text), &expected));
        }
    }
    let each = |values: Woven, of: &dyn Fn(f64) -> f64| Woven {
        warp: of(values.warp),
        weft: of(values.weft),
    };
    let mean = |values: Woven| 0.5 * (values.warp + values.weft);
    if let Some(reading) = find("density") {
        material.areal_density_kg_m2 = mean(reading.values);
    }
    let density = material.areal_density_kg_m2;
    for Reading { key, values, text } in readings {
        match key.name {
            "kes-b" => material.bending_n_m = each(*values, &units::bending_of_kes),
            "kes-g" => material.shear_n_per_m = units::shear_of_kes(mean(*values)),
            "kes-emt" => material.tension_n_per_m = each(*values, &units::tension_of_kes),
            "fast-c" => {
                let bending = |c: f64| units::bending_of_length(1e-3 * c, density);
                material.bending_n_m = each(*values, &bending);
            }
            "fast-eb5" => material.shear_n_per_m = units::shear_of_fast(mean(*values)),
            "fast-e20" => {
                let more = find("fast-e100").map(|more| more.values);
                let more = more.filter(|m| m.warp > values.warp && m.weft > values.weft);
                let more = more.ok_or_else(|| {
                    refuse(text.clone(), "fast-e100 beside it, with greater extensions")
                })?;
                let slope = units::tension_of_fast;
                material.tension_n_per_m = Woven {
                    warp: slope(values.warp, more.warp),
                    weft: slope(values.weft, more.weft),
                };
            }
            "fast-e100" if find("fast-e20").is_none() => {
                return Err(refuse(text.clone(), "fast-e20 beside it"));
            }
            _ => {}
        }
        material.assumed.retain(|assumed| assumed != key.sets);
    }
    if !readings.is_empty() {
        let texts: Vec<_> = readings.iter().map(|reading| reading.text.as_str()).collect();
        material.source = format!("{} Readings: {}.", material.source, texts.join("; "));
    }
    // The same checks as for a file.
    let text = serde_json::to_string(material)
        .map_err(|error| refuse(error.to_string(), "constants that can be written"))?;
    Material::parse(&text, "--reading").map(drop)
}
