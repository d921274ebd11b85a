//! The order of the page, and the studies that answer the reader's question.

use drape_report::page::{Outline, Part};

pub(super) const OUTLINE: Outline = Outline {
    parts: &[
        Part { title: "What it looks like", studies: &["pictures"], table_first: false },
        Part { title: "The paper’s tables beside ours", studies: &["tables"], table_first: true },
        Part {
            title: "Claims of the paper, and expectations",
            studies: &["claims"],
            table_first: true,
        },
        Part { title: "A way through the methods", studies: &["course"], table_first: false },
        Part { title: "The experiments", studies: &[], table_first: false },
    ],
    answers: &[
        "animation",
        "work-precision",
        "claims",
        "rest",
        "locking",
        "course",
        "order",
        "hard-cases",
    ],
    longest_answer: 3,
    leads: &[
        &["animation-frames.svg", "animation-map.svg"],
        &["work-precision.svg"],
        &["course-motion.svg"],
        &["motion-vs-stiffness.svg"],
    ],
};
