//! Prints the drape coefficient of a round cloth of 0.15 kg/m² at rest, by its flexural rigidity,
//! method and step: `cargo run --release --example drape_coefficient -p drape-tests`.
//!
//! What to compare it with: flexural rigidities of woven cloths are some 5e-6 to 6e-5 N m (an 11 oz
//! denim of 0.324 kg/m² has about 6e-5 N m: Wang, O'Brien and Ramamoorthi 2011). BS 5058:1973 tests
//! cloths as discs of 30 cm; those with a coefficient below 0.30, limp ones, as discs of 24 cm, and
//! those above 0.85, stiff ones, as discs of 36 cm (so B. P. Saville, Physical Testing of Textiles,
//! 1999, chapter 10): a woven cloth of medium stiffness has 0.30 to 0.85.

#![allow(clippy::print_stdout, reason = "a table for the reader")]

use drape_tests::drape::drape;

fn main() {
    println!("rigidity N m  method          step s   coefficient  speed left m/s");
    for (rigidity, method, h) in [
        (1.5e-6, "backward-euler", 0.005),
        (5e-6, "backward-euler", 0.005),
        (9e-6, "backward-euler", 0.005),
        (9e-6, "backward-euler", 0.0025),
        (9e-6, "baraff-witkin", 0.0025),
        (2e-5, "backward-euler", 0.005),
        (6e-5, "backward-euler", 0.005),
        (6e-4, "backward-euler", 0.005),
    ] {
        let found = drape(rigidity, method, h, 3.0);
        println!(
            "{rigidity:<12e}  {method:<14}  {h:<7}  {:<11.4}  {:.1e}",
            found.coefficient, found.speed
        );
    }
}
