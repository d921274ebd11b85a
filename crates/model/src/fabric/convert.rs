//! From a sheet's rigidities to springs, angles and hinges.
//!
//! # The sheet
//!
//! A woven sheet has small strains `ε₁` along the warp, `ε₂` along the weft, the shear angle `γ`
//! between them, and the curvatures `κ₁`, `κ₂`, `κ₁₂`. Its energy per area is
//!
//! ```text
//! W = ½ (C₁₁ ε₁² + 2 C₁₂ ε₁ ε₂ + C₂₂ ε₂² + G γ²)  +  ½ (B₁ κ₁² + B₂ κ₂²) + twist         (1)
//! ```
//!
//! `C₁₁`, `C₂₂` and `G` are in N/m, `B₁` and `B₂` in N m. `C₁₁` is the tension per width over the
//! strain while the other direction is held, as in a tester with a wide strip. Each conversion
//! gives the elements of one cell of the mesh the energy `W` times the area of the cell. An element
//! between two cells gets a share from both, so an element at the border gets half. This makes the
//! constants independent of the mesh.
//!
//! # Tension and shear springs of a rectangular cell
//!
//! A cell has the edges `a` along the warp and `b` along the weft. Let its edges carry springs `k₁`
//! and `k₂` (two each), and both diagonals, of length `ℓ² = a² + b²`, springs `k_d`. A spring along
//! a direction with cosine `c` and sine `s` has the strain `c² ε₁ + s² ε₂ + c s γ`. The sum of
//! `½ k ℓ² ε²` over the six springs, divided by `a b`, must be (1):
//!
//! ```text
//! G   = 2 k_d a b/ℓ²                                      k_d = G ℓ²/(2 a b)                (2)
//! C₁₁ = 2 k₁ a/b + G a²/b²                                k₁  = (C₁₁ − G a²/b²) b/(2 a)     (3)
//! C₂₂ = 2 k₂ b/a + G b²/a²                                k₂  = (C₂₂ − G b²/a²) a/(2 b)
//! C₁₂ = G
//! ```
//!
//! Springs are central forces: `C₁₂ = G` is Cauchy's relation, which no choice of springs avoids. A
//! cell needs `C₁₁ ≥ G a²/b²`. Shear by angles has no such bound, and `C₁₂ = 0`: a shear `γ` turns
//! all four corners of the cell by `γ`, so four angles of stiffness `κ_s` give
//!
//! ```text
//! 4 · ½ κ_s γ² = ½ G γ² a b                               κ_s = G a b/4                     (4)
//! ```
//!
//! # Springs of a triangle
//!
//! With `q = k ℓ²/A` of the triangle's three edges, (1) asks for
//!
//! ```text
//! Σ q c⁴ = C₁₁      Σ q s⁴ = C₂₂      Σ q c² s² = G                                          (5)
//! ```
//!
//! These are three equations for three springs. If a `q` comes out negative, as in a triangle
//! without an edge along the weft, no springs along the edges represent the sheet. The code then
//! takes `q = E(θ)`, Young's modulus of the sheet along the edge, with `C₁₂ = G`:
//!
//! ```text
//! 1/E(θ) = S₁₁ c⁴ + S₂₂ s⁴ + (2 S₁₂ + 1/G) c² s²                                             (6)
//! S₁₁ = C₂₂/Δ    S₂₂ = C₁₁/Δ    S₁₂ = −G/Δ    Δ = C₁₁ C₂₂ − G²
//! ```
//!
//! For an isotropic sheet (`C₁₁ = C₂₂ = 3 G`) `E(θ)` is the same in all directions, `E = 8 C₁₁/9`,
//! and (6) is the rule `k = E A/ℓ²` of A. Van Gelder (1998, *Approximate simulation of elastic
//! membranes by triangulated spring meshes*, Journal of Graphics Tools 3(2), 21–41,
//! doi:10.1080/10867651.1998.10487490). The rule is exact on equilateral triangles. On other
//! triangles it keeps `C₁₁ + C₂₂ + 2 G`, which no rotation of the axes changes. A mesh whose
//! material has no directions uses this rule, so its shear rigidity is a third of its tensile
//! rigidity.
//!
//! For cloth, whose `G` is far below `C₁₁`, use triangles only if they are halves of rectangles
//! along warp and weft. For these (5) is exact.
//!
//! # Bending by the angle along a row
//!
//! A row along the warp with spacing `a` bends by `δ = a κ₁` at each inner particle. The particle
//! stands for the length `a` of a strip of width `b`:
//!
//! ```text
//! ½ K δ² = ½ B₁ κ₁² a b                                   K = B₁ b/a                        (7)
//! ```
//!
//! Rows at the border stand for half the width. A clamp holds two columns. The angle at the second
//! column stands for half an edge on either side, so the clamp is in the middle of the held edge. A
//! sheet with such angles has no twisting rigidity and no coupling of `κ₁` and `κ₂`: a strip is as
//! stiff per width as a sheet.
//!
//! # Bending by springs that buckle
//!
//! A spring from each particle to the next but one, of length `2a`, pushes with `12 β/(2a)²` once
//! it has buckled, where `β` is the rigidity of its strip (Choi and Ko 2002, at small deflection).
//! A turn `δ` shortens it by `a δ²/4`, against the energy of the sheet:
//!
//! ```text
//! (3 β/a²)(a δ²/4) = ½ B₁ b δ²/a                          β = ⅔ B₁ b                        (8)
//! ```
//!
//! Two springs cover each piece of a row, which halves `β`. The square of the curvature of an arc
//! over the chord of a polygon is `¾` of the polygon's. drape's polynomial gives 3.028 in place of
//! 3, which [`Cell::buckling`] takes into account. Before it buckles, such a spring of compression
//! stiffness `k` resists like `δ⁴`, so the row is limp below the curvature `κ_b` at which it
//! buckles:
//!
//! ```text
//! k a δ²/4 = 3 β/a²     with δ = a κ_b                    k = 8 B₁ b/(a⁵ κ_b²)
//! ```
//!
//! A scene's material takes `κ_b` = 5/m. This alone does not make a row stiff. The struts also
//! stretch the tension springs, by the strain `2 B₁/(a² C₁₁)`, and push only after the turn exceeds
//! this strain. A row is limp below the curvature
//!
//! ```text
//! κ_m = 4 √(B₁/C₁₁)/a²
//! ```
//!
//! which grows as the mesh is refined. Denim has `κ_m` = 5/m on cells of 2 cm and 22/m on cells of
//! 1 cm. This model therefore suits coarse meshes of cloth that hardly stretches. A strip of it
//! does not converge to the cloth under refinement; a strip with angles does.
//!
//! *Linear* bending springs have no bending rigidity. Their energy is `k (a δ²/4)²/2`, of fourth
//! order in the turn, so a flat sheet of such springs bends freely. [`Cell::linear_spring`] matches
//! the energy at one curvature only, and its `k` grows as `1/a⁵ · b`.
//!
//! # Bending by hinges
//!
//! The law of drape's hinges is `K = 3 k |E|²/(A₁ + A₂)`. On an equilateral mesh every curvature has
//! the energy of an isotropic plate of rigidity `D = 3 k` and Poisson's ratio `ν = −⅓`:
//!
//! ```text
//! W = ½ D [κ₁² + κ₂² + 2 ν κ₁ κ₂ + 2 (1 − ν) κ₁₂²]                                           (9)
//! ```
//!
//! The reason: the fold over an edge of length `ℓ`, direction `t` and normal `n` is
//! `ℓ (3 κ_nn − κ_tt)/(2√3)`, and `W = (k/6) Σ (3 κ_nn − κ_tt)²` over the three directions.
//!
//! A *sheet* that is bent to a cylinder has `κ₂ = 0` and the rigidity `D`. A narrow *strip* with
//! free edges curls across to the same side, `κ₂ = −ν κ₁ = κ₁/3`, and has the rigidity `D (1 − ν²)`:
//!
//! | specimen | rigidity | so `k` of a measured `B` |
//! |---|---|---|
//! | sheet, wide or held at its sides | `3 k` | [`HingeFit::Sheet`]: `B/3` |
//! | strip, on equilateral triangles | `8 k/3` | [`HingeFit::Strip`]: `3 B/8` |
//! | strip, on squares cut along one diagonal | `12 k/5` | [`HingeFit::DiagonalStrip`]: `5 B/12` |
//!
//! On squares with one diagonal the fold angles are, from the second derivatives of the surface,
//!
//! ```text
//! edge along the weft: a (κ₁ ± κ₁₂)    edge along the warp: a (κ₂ ± κ₁₂)    diagonal: √2 a κ₁₂
//! W = ½ · 3k [(κ₁ ± κ₁₂)² + (κ₂ ± κ₁₂)² + 4 κ₁₂²]                                           (10)
//! ```
//!
//! The sign is that of the diagonal. A cylinder with `κ₁₂ = 0` has `3 k`. A narrow strip minimises
//! (10) over `κ₂` and `κ₁₂`: `κ₁₂ = ∓κ₁/5`, `κ₂ = ∓κ₁₂`, and `12 k/5`. It twists while it bends.
//!
//! The tables below were measured on strips of 10 to 80 edges, nearly inextensible. They show `H/W`
//! of the cantilever over that of the inextensible strip (`tests/cantilever.rs` of the oracle):
//!
//! | model | `Γ` | 10 | 20 | 40 | 80 | limit |
//! |---|---|---|---|---|---|---|
//! | angles | 1 | 0.9944 | 0.9987 | 0.9997 | 0.9999 | 1, second order |
//! | angles | 8 | 0.9914 | 0.9980 | 0.9995 | 0.9999 | 1, second order |
//! | hinges on a grid, 3 rows, `B/3` | 1 | 1.176 | 1.211 | 1.229 | 1.238 | 1.25 for small `Γ`, first order |
//! | hinges on a grid, 3 rows, `B/3` | 8 | 1.097 | 1.144 | 1.160 | 1.171 | 1.21 |
//!
//! Equilateral triangles in 3 rows with `3 B/8` reach 0.944, 0.994, 0.998 and 0.999 of that value
//! at `Γ` = 1 on 10, 20, 30 and 60 edges, and 0.876, 0.921, 0.943 and 0.986 at `Γ` = 8. In a strip
//! that bends far, the membrane resists the curling across. A wide strip of `B/3` is therefore
//! nearer to a sheet: 0.981 in 25 rows at `Γ` = 8.
//!
//! A real cloth shows hardly any such curling: warp and weft bend by themselves. A cantilever and a
//! pure bending tester therefore measure nearly the same rigidity, and the factor depends on the
//! *simulated* specimen. Use `B/3` for cloth that folds in cylinders, and the strip's factor to
//! reproduce a cantilever with a narrow strip of triangles. Between a wide sheet and a narrow strip
//! the rigidity depends on the width, by up to 12.5 %.
//!
//! If warp and weft differ, a hinge bends across its edge. With `θ` the angle of that direction
//! to the warp, its rigidity is
//!
//! ```text
//! B(θ) = (√B₁ cos²θ + √B₂ sin²θ)²                                                            (11)
//! ```
//!
//! which is `B₁` and `B₂` along warp and weft, constant if they are equal, and Huber's assumption
//! for the twist of orthotropic plates (M. T. Huber, 1923, *Die Theorie der kreuzweise bewehrten
//! Eisenbetonplatten*, Der Bauingenieur 4). On a grid, edges along warp and weft get exactly `B₂`
//! and `B₁`.

use super::Woven;
use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A rectangular cell of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Length of its edges along the warp, m.
    pub warp_m: f64,
    /// Length of its edges along the weft, m.
    pub weft_m: f64,
}

/// How hinges fit a measured bending rigidity; see [the derivation](self#bending-by-hinges).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HingeFit {
    /// A sheet that bends to a cylinder: `k = B/3`.
    #[default]
    Sheet,
    /// A narrow strip of equilateral triangles: `k = 3 B/8`.
    Strip,
    /// A narrow strip of squares that are cut along one diagonal, such as a grid: `k = 5 B/12`.
    DiagonalStrip,
}

impl HingeFit {
    /// The ratio `k/B` of a hinge's stiffness to the bending rigidity.
    pub fn factor(self) -> f64 {
        match self {
            Self::Sheet => 1.0 / 3.0,
            Self::Strip => 3.0 / 8.0,
            Self::DiagonalStrip => 5.0 / 12.0,
        }
    }
}

/// The value of `−P(1)` of the polynomial for strips that buckle, in place of 3.
const BUCKLED: f64 = 3.028;

impl Cell {
    /// Area, m².
    pub fn area(self) -> f64 {
        self.warp_m * self.weft_m
    }

    /// Stiffness of a spring along the warp and along the weft for the share of this cell, N/m,
    /// (3). `shear` is the rigidity that diagonal springs carry, N/m; 0 without them. A negative
    /// stiffness means that the diagonals alone are stiffer than the sheet.
    pub fn tension(self, tension: Woven, shear: f64) -> Woven {
        let ratio = self.warp_m / self.weft_m;
        Woven {
            warp: (tension.warp - shear * ratio * ratio) / (2.0 * ratio),
            weft: (tension.weft - shear / (ratio * ratio)) * ratio / 2.0,
        }
    }

    /// Stiffness of a diagonal spring, N/m, for a shear rigidity, N/m, (2).
    pub fn diagonal(self, shear: f64) -> f64 {
        let square = self.warp_m * self.warp_m + self.weft_m * self.weft_m;
        shear * square / (2.0 * self.area())
    }

    /// Stiffness of each of the cell's four angles, N m, for a shear rigidity, N/m, (4).
    pub fn shear_angle(self, shear: f64) -> f64 {
        0.25 * shear * self.area()
    }

    /// Stiffness of an angle of a row along the warp and along the weft for the share of this cell,
    /// N m: half of (7).
    pub fn bending_angle(self, bending: Woven) -> Woven {
        let ratio = self.warp_m / self.weft_m;
        Woven { warp: 0.5 * bending.warp / ratio, weft: 0.5 * bending.weft * ratio }
    }

    /// Rigidity, N m², of a bending spring that buckles, for the share of this cell: half of (8).
    pub fn buckling(self, bending: Woven) -> Woven {
        let factor = 3.0 / BUCKLED / 3.0;
        Woven {
            warp: factor * bending.warp * self.weft_m,
            weft: factor * bending.weft * self.warp_m,
        }
    }

    /// Stiffness, N/m, with which the springs of [`buckling`](Self::buckling) resist compression
    /// until the row has this curvature (1/m), for the share of this cell.
    pub fn before_buckling(self, bending: Woven, curvature: f64) -> Woven {
        let linear = self.linear_spring(bending, curvature);
        Woven { warp: 0.5 * linear.warp, weft: 0.5 * linear.weft }
    }

    /// Stiffness, N/m, of a linear bending spring whose energy is the sheet's at this curvature
    /// (1/m), for the share of this cell. At other curvatures the energies differ.
    pub fn linear_spring(self, bending: Woven, curvature: f64) -> Woven {
        let stiffness = |b: f64, along: f64, across: f64| {
            8.0 * b * across / (along.powi(5) * curvature * curvature)
        };
        Woven {
            warp: stiffness(bending.warp, self.warp_m, self.weft_m),
            weft: stiffness(bending.weft, self.weft_m, self.warp_m),
        }
    }
}

/// Bending rigidity along a direction, N m, (11). `squared_cosine` is `cos² θ` of the angle to the
/// warp.
pub fn bending_along(bending: Woven, squared_cosine: f64) -> f64 {
    let root = bending.warp.sqrt() * squared_cosine + bending.weft.sqrt() * (1.0 - squared_cosine);
    root * root
}

/// Young's modulus along a direction, N/m, (6). `squared_cosine` is `cos² θ` of the angle to the
/// warp.
pub fn tension_along(tension: Woven, shear: f64, squared_cosine: f64) -> f64 {
    let (c, s) = (squared_cosine, 1.0 - squared_cosine);
    let determinant = tension.warp * tension.weft - shear * shear;
    let compliance = (tension.weft * c * c + tension.warp * s * s - 2.0 * shear * c * s)
        / determinant
        + c * s / shear;
    1.0 / compliance
}

/// Squared lengths of a triangle's edges, their squared cosines to the warp, and its area, m².
fn edges(corners: [[f64; 2]; 3]) -> Option<([f64; 3], [f64; 3], f64)> {
    let edge = |i: usize| {
        let [a, b] = [corners[(i + 1) % 3], corners[(i + 2) % 3]];
        [b[0] - a[0], b[1] - a[1]]
    };
    let edges = [edge(0), edge(1), edge(2)];
    let area = 0.5 * (edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]).abs();
    let squares = edges.map(|e| e[0] * e[0] + e[1] * e[1]);
    let longest = squares.iter().fold(0.0, |most: f64, square| most.max(*square));
    let cosines = [0, 1, 2].map(|i| edges[i][0] * edges[i][0] / squares[i]);
    (area > 1e-12 * longest).then_some((squares, cosines, area))
}

/// Stiffness of the springs along the edges of a triangle, for its share of an isotropic sheet,
/// N/m, by Van Gelder's rule. `tension` is the tensile rigidity `C₁₁`, N/m. Edge `i` is opposite
/// corner `i`. `None` if the triangle has no area.
pub fn isotropic_springs(corners: [[f64; 2]; 3], tension: f64) -> Option<[f64; 3]> {
    let (squares, _, area) = edges(corners)?;
    Some(squares.map(|square| 8.0 / 9.0 * tension * area / square))
}

/// Stiffness of the springs along the edges of a triangle, for its share of the sheet, N/m, (5) or
/// (6). Edge `i` is opposite corner `i`; corners are along warp and weft, m. `None` if
/// `C₁₁ C₂₂ ≤ G²`, or if the triangle has no area.
pub fn triangle_springs(corners: [[f64; 2]; 3], tension: Woven, shear: f64) -> Option<[f64; 3]> {
    let (squares, cosines, area) = edges(corners)?;
    if tension.warp * tension.weft <= shear * shear {
        return None;
    }
    let rows = [
        cosines.map(|c| c * c),
        cosines.map(|c| (1.0 - c) * (1.0 - c)),
        cosines.map(|c| c * (1.0 - c)),
    ];
    let matrix = Matrix3::from_fn(|row, column| rows[row][column]);
    let wanted = Vector3::new(tension.warp, tension.weft, shear);
    let exact = matrix.try_inverse().map(|inverse| inverse * wanted);
    let q = match exact {
        Some(q) if q.iter().all(|q| *q >= 0.0 && q.is_finite()) => [q.x, q.y, q.z],
        _ => cosines.map(|c| tension_along(tension, shear, c)),
    };
    Some([0, 1, 2].map(|i| q[i] * area / squares[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOTH: Woven = Woven { warp: 200.0, weft: 1000.0 };

    fn near(a: f64, b: f64) {
        assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    }

    /// Energy per area of springs in homogeneous strain: `½ Σ k ℓ² ε²/A`.
    fn energy(springs: &[([f64; 2], f64)], area: f64, strain: [f64; 3]) -> f64 {
        let of = |([x, y], k): &([f64; 2], f64)| {
            let square = x * x + y * y;
            let along = (x * x * strain[0] + y * y * strain[1] + x * y * strain[2]) / square;
            0.5 * k * square * along * along
        };
        springs.iter().map(of).sum::<f64>() / area
    }

    #[test]
    fn springs_of_a_cell_have_the_energy_of_the_sheet() {
        for (a, b) in [(0.02, 0.02), (0.03, 0.02), (0.01, 0.02)] {
            let cell = Cell { warp_m: a, weft_m: b };
            let shear = 20.0;
            let edges = cell.tension(CLOTH, shear);
            let diagonal = cell.diagonal(shear);
            let springs = [
                ([a, 0.0], edges.warp),
                ([a, 0.0], edges.warp),
                ([0.0, b], edges.weft),
                ([0.0, b], edges.weft),
                ([a, b], diagonal),
                ([-a, b], diagonal),
            ];
            let measured = |strain| energy(&springs, cell.area(), strain);
            near(measured([1.0, 0.0, 0.0]), 0.5 * CLOTH.warp);
            near(measured([0.0, 1.0, 0.0]), 0.5 * CLOTH.weft);
            near(measured([0.0, 0.0, 1.0]), 0.5 * shear);
            near(measured([1.0, 1.0, 0.0]), 0.5 * (1200.0 + 2.0 * shear));
        }
    }

    #[test]
    fn springs_of_halved_rectangles_and_of_isotropic_triangles_are_the_sheet() {
        let corners = [[0.0, 0.0], [0.03, 0.0], [0.03, 0.02]];
        let shear = 20.0;
        let k = triangle_springs(corners, CLOTH, shear).expect("a triangle");
        let springs = [([0.0, 0.02], k[0]), ([0.03, 0.02], k[1]), ([0.03, 0.0], k[2])];
        let measured = |strain| energy(&springs, 0.0003, strain);
        near(measured([1.0, 0.0, 0.0]), 0.5 * CLOTH.warp);
        near(measured([0.0, 1.0, 0.0]), 0.5 * CLOTH.weft);
        near(measured([0.0, 0.0, 1.0]), 0.5 * shear);
        // Van Gelder's rule on an equilateral triangle, turned by any angle: k = √3/4 E for one
        // side of an edge.
        for turn in [0.0_f64, 0.3, 1.0] {
            let at = |angle: f64| [(turn + angle).cos(), (turn + angle).sin()];
            let corners = [0.0, 2.0, 4.0].map(|k| at(k * std::f64::consts::FRAC_PI_3));
            let even = Woven::even(9.0 / 8.0);
            let k = triangle_springs(corners, even, 3.0 / 8.0).expect("a triangle");
            let plain = isotropic_springs(corners, 9.0 / 8.0).expect("a triangle");
            k.iter().zip(plain).for_each(|(k, plain)| assert!((k - plain).abs() < 1e-12));
            k.iter().for_each(|k| assert!((k - 3_f64.sqrt() / 4.0).abs() < 1e-12, "{turn} {k}"));
        }
        assert!(triangle_springs(corners, CLOTH, 500.0).is_none());
    }

    #[test]
    fn a_triangle_without_an_edge_along_the_weft_falls_back_to_moduli_of_directions() {
        let height = 0.75_f64.sqrt();
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.5, height]];
        let k = triangle_springs(corners, CLOTH, 20.0).expect("a triangle");
        let along = |c| tension_along(CLOTH, 20.0, c) * 0.5 * height;
        near(k[2], along(1.0));
        near(k[0], along(0.25));
        assert!(k.iter().all(|k| *k > 0.0));
    }

    #[test]
    fn rigidities_along_warp_and_weft_are_those_of_the_cloth() {
        let bending = Woven { warp: 2e-5, weft: 8e-5 };
        near(bending_along(bending, 1.0), 2e-5);
        near(bending_along(bending, 0.0), 8e-5);
        near(bending_along(Woven { warp: 3.0, weft: 3.0 }, 0.37), 3.0);
        near(tension_along(CLOTH, 20.0, 1.0), CLOTH.warp - 400.0 / CLOTH.weft);
    }

    #[test]
    fn a_cell_turned_by_a_quarter_has_the_numbers_of_warp_and_weft_in_exchange() {
        let cells = [(0.03, 0.02), (0.02, 0.03)].map(|(a, b)| Cell { warp_m: a, weft_m: b });
        let cloths = [(2.0, 7.0), (7.0, 2.0)].map(|(warp, weft)| Woven { warp, weft });
        let conversions: [&dyn Fn(Cell, Woven) -> Woven; 5] = [
            &|cell, tension| cell.tension(tension, 0.3),
            &|cell, bending| cell.bending_angle(bending),
            &|cell, bending| cell.buckling(bending),
            &|cell, bending| cell.before_buckling(bending, 10.0),
            &|cell, bending| cell.linear_spring(bending, 10.0),
        ];
        for convert in conversions {
            let [a, b] = [0, 1].map(|turned| convert(cells[turned], cloths[turned]));
            near(a.warp, b.weft);
            near(a.weft, b.warp);
        }
    }
}
