//! Names of forms and methods in sentences.

/// A sentence names at most one method more than this. If there are more methods, it names this
/// many and counts the rest.
const MOST: usize = 4;

/// Each label once, in the order of the record.
pub(super) fn labels<'a>(all: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut labels: Vec<&str> = Vec::new();
    for label in all {
        if !labels.contains(&label) {
            labels.push(label);
        }
    }
    labels
}

/// The names of the methods of some forms, as text. A form's label is the method and, after a
/// comma, its special settings.
pub(super) fn methods(labels_of_forms: &[&str]) -> String {
    let of = |label: &'_ &str| label.split(',').next().map_or(0, str::len);
    let names = labels(labels_of_forms.iter().map(|label| &label[..of(label)]));
    listed(&names)
}

/// Names as text: `a`, `b` and `c`. If there are too many, the text counts the last ones.
pub(super) fn listed(names: &[&str]) -> String {
    let shown = if names.len() > MOST + 1 { MOST } else { names.len() };
    let mut shown: Vec<String> = names[..shown].iter().map(|name| format!("`{name}`")).collect();
    if shown.len() < names.len() {
        shown.push(format!("{} more", names.len() - shown.len()));
    }
    match shown.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => shown.concat(),
    }
}

/// A sentence that counts forms and names their methods; `None` without any. The verb follows the
/// number: for one form, and for several.
pub(super) fn told(forms: &[&str], verbs: [&str; 2], rest: &str) -> Option<String> {
    let [of_one, of_several] = verbs;
    let (number, verb) = (forms.len(), verb(forms.len(), of_one, of_several));
    (number > 0).then(|| format!("{} {verb} {rest}; {}.", count(number, "form"), theirs(forms)))
}

/// The names of the methods of some forms, as `its method is ..` or `their methods are ..`.
pub(super) fn theirs(forms: &[&str]) -> String {
    let names = methods(forms);
    match forms.len() {
        1 => format!("its method is {names}"),
        _ if names.contains("` and ") => format!("their methods are {names}"),
        _ => format!("their method is {names}"),
    }
}

/// A number with its noun, as `1 run` or `2 runs`.
pub(super) fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}

/// The verb that goes with a number: `of_one` or `of_several`.
pub(super) fn verb<'a>(number: usize, of_one: &'a str, of_several: &'a str) -> &'a str {
    if number == 1 { of_one } else { of_several }
}

/// The range from the least to the greatest value, as `told` writes them. `None` without values.
pub(super) fn range(values: &[f64], told: impl Fn(f64) -> String) -> Option<String> {
    let least = told(values.iter().copied().reduce(f64::min)?);
    let most = told(values.iter().copied().reduce(f64::max)?);
    Some(if least == most { least } else { format!("{least} to {most}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_has_five_names_at_most() {
        assert_eq!(labels(["b", "a", "b"].into_iter()), ["b", "a"]);
        assert_eq!(methods(&[]), "");
        assert_eq!(methods(&["bdf2, CG", "bdf2, safeguarded"]), "`bdf2`");
        assert_eq!(methods(&["bdf2, CG", "dirk"]), "`bdf2` and `dirk`");
        assert_eq!(methods(&["a", "b", "c", "d", "e"]), "`a`, `b`, `c`, `d` and `e`");
        assert_eq!(methods(&["a", "b", "c", "d", "e", "f"]), "`a`, `b`, `c`, `d` and 2 more");
    }

    #[test]
    fn a_number_agrees_with_its_noun_and_its_verb() {
        let told = |forms: &[&str]| told(forms, ["locks", "lock"], "on a table");
        assert_eq!(told(&[]), None);
        assert_eq!(
            told(&["a, CG"]).as_deref(),
            Some("1 form locks on a table; its method is `a`.")
        );
        let same = "2 forms lock on a table; their method is `a`.";
        assert_eq!(told(&["a, CG", "a, IC(0)"]).as_deref(), Some(same));
        let two = "2 forms lock on a table; their methods are `a` and `b`.";
        assert_eq!(told(&["a", "b"]).as_deref(), Some(two));
        assert_eq!((count(1, "run"), count(2, "run")), ("1 run".to_owned(), "2 runs".to_owned()));
        assert_eq!((verb(1, "is", "are"), verb(0, "is", "are")), ("is", "are"));
    }

    #[test]
    fn a_range_has_its_ends_alone() {
        let told = |value: f64| format!("{value:.0}");
        assert_eq!(range(&[3.0, 1.0, 2.0], told).as_deref(), Some("1 to 3"));
        assert_eq!(range(&[1.1, 1.2], told).as_deref(), Some("1"));
        assert_eq!(range(&[], told), None);
    }
}
