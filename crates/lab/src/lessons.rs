//! Lessons as the page shows them: text, equation, code, curve, panes, question. The server marks
//! answers, so the page never holds the right one.

use crate::messages::Reply;
use crate::setup::Setup;
use drape_harness::lessons::{Lesson, Setting, find, lessons};
use drape_integrator::Method;
use serde::Serialize;

/// A lesson in the list.
#[derive(Debug, Serialize)]
pub struct Listed {
    /// Id of its method.
    id: &'static str,
    /// Its title.
    title: &'static str,
}

/// A lesson.
#[derive(Debug, Serialize)]
pub struct Told {
    /// Id of its method.
    id: &'static str,
    title: &'static str,
    idea: &'static str,
    equation: String,
    /// File of the equation, from the root of drape.
    equation_file: String,
    code: String,
    code_file: String,
    /// Pairs of a step size, s, and the factor by which such a step multiplies the motion. Factors
    /// that are not finite are left out.
    radii: Vec<(f64, f64)>,
    panes: Vec<Setup>,
    question: String,
    unit: &'static str,
    way: &'static str,
    attempt: &'static str,
    /// The command that repeats the first pane.
    repeat: String,
    /// Name of the file that the command reads; `None` for a bundled scene.
    file: Option<String>,
    /// The crate whose documentation explains the method.
    docs: &'static str,
    study: &'static str,
}

/// The set-ups that a lesson opens.
pub fn setups(setting: &Setting) -> Vec<Setup> {
    let setup = |method: &&str| Setup {
        scene: setting.scene.to_owned(),
        method: (*method).to_owned(),
        stiffness: Some(setting.stiffness),
        damping: Some(setting.damping),
        step: Some(setting.step),
        duration: Some(setting.duration),
        particles: None,
        gravity: None,
        wind: None,
    };
    setting.methods.iter().map(setup).collect()
}

/// All lessons.
pub(crate) fn list() -> Reply<'static> {
    let listed = |(method, lesson): (&'static Method, &'static Lesson)| Listed {
        id: method.id,
        title: lesson.title,
    };
    Reply::Lessons { lessons: lessons().map(listed).collect() }
}

/// The lesson on the method of that id.
pub(crate) fn tell(id: &str) -> Result<Reply<'static>, String> {
    let (method, lesson) = find(id)?;
    let lost = |what: &str| format!("the lesson {id} lost its {what}; please report it");
    let panes = setups(&lesson.setting);
    let stage = panes.first().ok_or_else(|| lost("panes"))?.stage();
    let stage = stage.map_err(|error| error.to_string())?;
    let repeat = stage.repeat(0).map_err(|error| error.to_string())?;
    let told = Told {
        id: method.id,
        title: lesson.title,
        idea: lesson.idea,
        equation: lesson.equation().ok_or_else(|| lost("equation"))?,
        equation_file: lesson.file(&lesson.equation),
        code: lesson.code().ok_or_else(|| lost("code"))?,
        code_file: lesson.file(&lesson.code),
        radii: lesson.radii().into_iter().filter(|(_, radius)| radius.is_finite()).collect(),
        panes,
        question: lesson.question.text(&lesson.setting),
        unit: lesson.question.unit(),
        way: lesson.question.way(),
        attempt: lesson.attempt,
        repeat: repeat.command,
        file: repeat.file,
        docs: lesson.docs,
        study: lesson.study,
    };
    Ok(Reply::Lesson { lesson: Box::new(told) })
}

/// Marks an answer.
pub(crate) fn mark(id: &str, value: f64) -> Result<Reply<'static>, String> {
    let (method, lesson) = find(id)?;
    let mark = lesson.mark(value)?;
    Ok(Reply::Marked { lesson: method.id, right: mark.is_right, sentence: mark.sentence })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::{Out, Runs, Session};
    use serde_json::{Value, json};

    fn ask(request: &Value) -> Value {
        let replies = Session::new(Runs::default()).receive(&request.to_string());
        let [Out::Text(text)] = replies.as_slice() else { panic!("{replies:?}") };
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn a_session_lists_tells_and_marks() {
        let list = ask(&json!({ "do": "lessons" }));
        let listed = list["lessons"].as_array().unwrap();
        assert_eq!((list["tell"].as_str(), listed.len()), (Some("lessons"), lessons().count()));
        for (method, lesson) in lessons() {
            let told = ask(&json!({ "do": "lesson", "id": method.id }));
            let told = &told["lesson"];
            assert_eq!(told["id"], method.id, "{told}");
            for part in ["title", "idea", "equation", "code", "question", "way", "attempt"] {
                assert!(told[part].as_str().unwrap().len() > 10, "{}, {part}: {told}", method.id);
            }
            assert!(told["repeat"].as_str().unwrap().starts_with("drape run "), "{told}");
            assert!(told["radii"].as_array().unwrap().len() > 10, "{told}");
            let answer =
                |value: f64| ask(&json!({ "do": "answer", "lesson": method.id, "value": value }));
            let right = answer(lesson.answer());
            assert!(right["tell"] == "marked" && right["right"] == true, "{right}");
            assert_eq!(answer(3.0 * lesson.answer())["right"], false, "{}", method.id);
        }
    }

    #[test]
    fn an_unknown_lesson_is_refused_by_name_and_so_is_an_answer_that_is_no_number() {
        for (request, named) in [
            (json!({ "do": "lesson", "id": "magic" }), "no lesson `magic`; expected one of"),
            (json!({ "do": "answer", "lesson": "magic", "value": 1 }), "no lesson `magic`"),
            (json!({ "do": "answer", "lesson": "leapfrog", "value": null }), "no request"),
            (json!({ "do": "answer", "lesson": "leapfrog" }), "value"),
            (json!({ "do": "lessons", "id": 1 }), "id"),
        ] {
            let refused = ask(&request);
            assert_eq!(refused["tell"], "refused", "{request}");
            assert!(refused["sentence"].as_str().unwrap().contains(named), "{refused}");
        }
    }
}
