//! Converts the description that a program sends into the description of a method.

use crate::message::{Hello, PROTOCOL};
use drape_integrator::{Kind, Method, Order, Quantity, Setting, StabilityClass, Supports};
use drape_model::EffectKind;

/// What a program can support beside the effects.
const CONSTRAINTS: [&str; 7] = [
    "pins",
    "moving pins",
    "contact",
    "friction",
    "moving obstacles",
    "full damping",
    "projected damping",
];

/// Everything that a program can support, by the names that `drape list methods` prints.
fn all() -> Vec<&'static str> {
    EffectKind::ALL.iter().map(|kind| kind.name()).chain(CONSTRAINTS).collect()
}

/// Keeps a text for the rest of the process: methods are described by static texts, and a process
/// loads few programs.
pub(crate) fn kept(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}

fn kept_list<T>(list: Vec<T>) -> &'static [T] {
    Box::leak(list.into_boxed_slice())
}

/// What a program says about itself.
#[derive(Debug)]
pub(crate) struct Description {
    order: Order,
    class: StabilityClass,
    conserves: Vec<Quantity>,
    refuses: Vec<&'static str>,
}

impl Hello {
    /// The method, or what is wrong with the description.
    pub(crate) fn method(&self, id: &str, command: &str) -> Result<&'static Method, String> {
        let Description { order, class, conserves, refuses } = self.description()?;
        let or = |text: &str, other: &'static str| {
            if text.is_empty() { other } else { kept(text) }
        };
        Ok(Box::leak(Box::new(Method {
            id: kept(id),
            name: kept(&self.name),
            source: or(&self.source, "a program of the user"),
            order,
            class,
            conserves: kept_list(conserves),
            theory: or(&self.theory, "nothing is stated about its stability"),
            supports: if self.implicit { Supports::Blocks } else { Supports::Explicit },
            refuses: kept_list(refuses),
            settings: settings(command),
        })))
    }

    /// What it says in the words of drape, or what is wrong with it.
    pub(crate) fn description(&self) -> Result<Description, String> {
        let wrong = |key: &str, value: &str, expected: &str| {
            Err(format!("answered `hello` with `{key}` {value}; expected {expected}"))
        };
        if self.protocol != PROTOCOL {
            return wrong("protocol", &format!("{:?}", self.protocol), &format!("{PROTOCOL:?}"));
        }
        let order = match self.order {
            1 => Order::One,
            2 => Order::Two,
            3 => Order::Three,
            4 => Order::Four,
            other => return wrong("order", &other.to_string(), "1, 2, 3 or 4"),
        };
        let class = match self.class.as_str() {
            "dissipative" => StabilityClass::Dissipative,
            "symplectic" => StabilityClass::Symplectic,
            other => {
                return wrong("class", &format!("{other:?}"), "\"dissipative\" or \"symplectic\"");
            }
        };
        let mut conserves = Vec::new();
        for name in &self.conserves {
            let all = [Quantity::Momentum, Quantity::AngularMomentum, Quantity::Energy];
            match all.into_iter().find(|quantity| quantity.name() == name) {
                Some(quantity) => conserves.push(quantity),
                None => {
                    let expected = "\"momentum\", \"angular momentum\" or \"energy\"";
                    return wrong("conserves", &format!("{name:?}"), expected);
                }
            }
        }
        let known = all();
        for name in &self.supports {
            if !known.contains(&name.as_str()) {
                return wrong("supports", &format!("{name:?}"), &known.join(", "));
            }
        }
        let is_refused = |name: &&str| !self.supports.iter().any(|own| own == name);
        let refuses = known.iter().copied().filter(is_refused).collect();
        Ok(Description { order, class, conserves, refuses })
    }
}

/// The command, which is as it is, and the time limits.
fn settings(command: &str) -> &'static [Setting] {
    let command = kept(command);
    let seconds = Kind::Number { min: 0.01, max: 86_400.0 };
    kept_list(vec![
        Setting {
            key: "command",
            kind: Kind::Choice(kept_list(vec![command])),
            default: command,
            help: "the program and its arguments",
        },
        Setting {
            key: "start_timeout",
            kind: seconds,
            default: "60",
            help: "seconds after which it is killed while it starts or reads a system",
        },
        Setting {
            key: "step_timeout",
            kind: seconds,
            default: "60",
            help: "seconds after which it is killed in a step",
        },
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hello() -> Hello {
        Hello {
            protocol: PROTOCOL.to_owned(),
            name: "mine".to_owned(),
            source: String::new(),
            theory: String::new(),
            order: 2,
            class: "symplectic".to_owned(),
            conserves: vec!["angular momentum".to_owned()],
            implicit: true,
            supports: vec!["tension".to_owned(), "gravity".to_owned(), "pins".to_owned()],
        }
    }

    #[test]
    fn what_is_not_supported_is_refused() {
        let method = hello().method("program:x", "x").expect("valid");
        assert_eq!(
            (method.id, method.order, method.supports),
            ("program:x", Order::Two, Supports::Blocks)
        );
        assert_eq!(method.conserves, [Quantity::AngularMomentum]);
        for refused in ["shear", "air", "contact", "moving pins", "projected damping"] {
            assert!(method.refuses.contains(&refused), "{refused}");
        }
        for supported in ["tension", "gravity", "pins"] {
            assert!(!method.refuses.contains(&supported), "{supported}");
        }
    }

    #[test]
    fn a_wrong_word_is_named_with_what_is_allowed() {
        type Change = fn(&mut Hello);
        let changes: [(Change, &str, &str); 5] = [
            (|h| h.protocol = "drape-method/2".into(), "drape-method/2", "drape-method/1"),
            (|h| h.order = 5, "`order` 5", "1, 2, 3 or 4"),
            (|h| h.class = "good".into(), "good", "dissipative"),
            (|h| h.conserves = vec!["mass".into()], "mass", "angular momentum"),
            (|h| h.supports.push("wind".into()), "wind", "air"),
        ];
        for (change, found, expected) in changes {
            let mut wrong = hello();
            change(&mut wrong);
            let said = wrong.method("program:x", "x").expect_err("refused");
            assert!(said.contains(found) && said.contains(expected), "{said}");
        }
    }
}
