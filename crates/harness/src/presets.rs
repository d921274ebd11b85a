//! Presets: named settings with which a paper prints a method, where they differ from the defaults.

use crate::methods;
use drape_integrator::Method;

/// Named settings of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Its name, which stands first after the colon of `id:name`.
    pub name: &'static str,
    /// Its settings.
    pub settings: &'static [(&'static str, &'static str)],
    /// Help text.
    pub help: &'static str,
}

impl Preset {
    /// The id of its method with its settings, as [`Choice::parse`](crate::methods::Choice::parse)
    /// reads them.
    pub fn written_out(&self, method: &Method) -> String {
        let pairs: Vec<_> =
            self.settings.iter().map(|(key, value)| format!("{key}={value}")).collect();
        format!("{}:{}", method.id, pairs.join(","))
    }
}

/// The presets of a method.
pub fn presets(method: &Method) -> impl Iterator<Item = &'static Preset> {
    methods::runs_of(method.id).map_or(&[][..], |runs| runs.presets).iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::Choice;

    fn id(text: &str) -> String {
        Choice::parse(text, &[]).unwrap_or_else(|error| panic!("{error}")).full_id()
    }

    #[test]
    fn a_preset_is_what_it_writes_out_and_no_default() {
        let of = |method| presets(method).map(move |preset| (method, preset));
        let all: Vec<_> = methods::all().flat_map(of).collect();
        assert!(all.len() >= 3);
        for (known, preset) in all {
            let (method, name) = (known.id, preset.name);
            assert_eq!(id(&format!("{method}:{name}")), id(&preset.written_out(known)));
            for pair in preset.settings {
                let choice = Choice::parse(method, &[]).unwrap_or_else(|error| panic!("{error}"));
                assert_ne!(choice.settings().get(pair.0), Some(pair.1), "{method}: {pair:?}");
            }
        }
    }

    #[test]
    fn further_settings_go_before_those_of_a_preset() {
        let text = "imex-euler:paper,norm=velocity,forcing_term=0.05";
        assert_eq!(id(text), id("imex-euler:split=paper,forcing_term=0.05"));
        let more = ["norm=preconditioned".to_owned()];
        let choice = Choice::parse("imex-euler:paper", &more).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(choice.settings().get("norm"), Some("preconditioned"));
        assert_eq!(choice.settings().get("split"), Some("paper"));
    }

    #[test]
    fn a_name_that_is_no_preset_is_refused() {
        let refused = |text: &str| match Choice::parse(text, &[]) {
            Err(error) => error.to_string(),
            Ok(choice) => panic!("{} taken as {}", text, choice.full_id()),
        };
        let preset = "imex-euler: setting `papr`; expected key=value, or first the preset paper";
        assert_eq!(refused("imex-euler:papr"), preset);
        assert_eq!(refused("provot:paper"), "provot: setting `paper`; expected key=value");
        assert!(refused("imex-euler:start=last,paper").contains("setting `paper`"));
    }
}
