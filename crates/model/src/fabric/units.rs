//! Readings of textile instruments in SI units.
//!
//! | instrument | reading | unit there | here |
//! |---|---|---|---|
//! | KES-FB2 | bending rigidity `B` | gf cm²/cm | [`bending_of_kes`], N m |
//! | KES-FB1 | shear stiffness `G` | gf/(cm degree) | [`shear_of_kes`], N/m |
//! | KES-FB1 | extension `EMT` at 500 gf/cm | % | [`tension_of_kes`], N/m |
//! | FAST-2, BS 3356, ASTM D1388 | bending length `c` | m | [`bending_of_length`], N m |
//! | FAST-3 | extensions `E20`, `E100` at 20 and 100 gf/cm | % | [`tension_of_fast`], N/m |
//! | FAST-3 | bias extension `EB5` at 5 gf/cm | % | [`shear_of_fast`], N/m |
//!
//! KES is Kawabata's system (S. Kawabata, 1980, *The Standardization and Analysis of Hand
//! Evaluation*, 2nd ed., Textile Machinery Society of Japan). FAST is the system of CSIRO (A. De
//! Boos and D. Tester, 1994, *SiroFAST*, report WT92.02, ISBN 0 643 06025 1).
//!
//! All rigidities are per width. A tension of 1 gf/cm is 0.980665 N/m.

use crate::bounds::STANDARD_GRAVITY;

/// 1 gf/cm, N/m.
const GRAM_FORCE_PER_CM: f64 = 0.980_665;

/// Bending rigidity, N m, of a reading in gf cm²/cm: 1 gf cm = 9.80665e-5 N m.
///
/// ```
/// let b = drape_model::fabric::units::bending_of_kes(0.1);
/// assert!((b - 9.80665e-6).abs() < 1e-15);
/// ```
pub fn bending_of_kes(gf_cm2_per_cm: f64) -> f64 {
    1e-4 * GRAM_FORCE_PER_CM * gf_cm2_per_cm
}

/// Shear rigidity, N/m, of a reading in gf/(cm degree). KES shears a strip by an angle `φ` and
/// measures the slope of the force per width over `φ`; `tan φ ≈ φ`.
///
/// ```
/// let g = drape_model::fabric::units::shear_of_kes(1.0);
/// assert!((g - 56.188).abs() < 1e-3);
/// ```
pub fn shear_of_kes(gf_per_cm_degree: f64) -> f64 {
    GRAM_FORCE_PER_CM * gf_per_cm_degree.to_degrees()
}

/// Secant tensile rigidity, N/m, of the extension `EMT` (%) at 500 gf/cm. Cloth stiffens as it is
/// stretched, so under its own weight it is softer than the secant.
pub fn tension_of_kes(emt_percent: f64) -> f64 {
    500.0 * GRAM_FORCE_PER_CM / (0.01 * emt_percent)
}

/// Bending rigidity, N m, of a bending length (m) and an areal density (kg/m²): `B = ρ g c³`.
///
/// Peirce's bending length is half of the length at which a strip that hangs over an edge has a
/// chord angle of 41.5°. At that length `ρ g L³/B = 8` (F. T. Peirce, 1930, *The "handle" of cloth
/// as a measurable quantity*, Journal of the Textile Institute 21, T377,
/// doi:10.1080/19447023008661529).
///
/// ```
/// let b = drape_model::fabric::units::bending_of_length(0.02, 0.2);
/// assert!((b - 0.2 * 9.80665 * 8e-6).abs() < 1e-18);
/// ```
pub fn bending_of_length(bending_length_m: f64, areal_density_kg_m2: f64) -> f64 {
    areal_density_kg_m2 * STANDARD_GRAVITY * bending_length_m.powi(3)
}

/// Tensile rigidity, N/m, of the extensions (%) at 20 and 100 gf/cm: the slope between them.
pub fn tension_of_fast(e20_percent: f64, e100_percent: f64) -> f64 {
    80.0 * GRAM_FORCE_PER_CM / (0.01 * (e100_percent - e20_percent))
}

/// Shear rigidity, N/m, of the bias extension `EB5` (%): `G = 123/EB5`.
///
/// A strip cut at 45° carries the tension `T`. Its strain is `T/4 (1/E₁ + 1/E₂ − 2ν₁/E₁ + 1/G)`.
/// Cloth has `G ≪ E`, so `G ≈ T/(4 ε)`. With `T` = 5 gf/cm and `ε` in percent this is 122.6/EB5;
/// FAST rounds it.
pub fn shear_of_fast(eb5_percent: f64) -> f64 {
    123.0 / eb5_percent
}
