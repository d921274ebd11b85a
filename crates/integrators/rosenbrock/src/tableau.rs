//! The tableaux of the method.
#![expect(clippy::excessive_precision, reason = "digits as published")]

use drape_integrator::{Order, Word};

/// Most stages of a tableau.
pub const STAGES: usize = 6;

type Matrix = [[f64; STAGES]; STAGES];
type Row = [f64; STAGES];

/// The coefficients of a Rosenbrock method in the form that needs no product with the Jacobian.
///
/// The increments `k_i` of the definition become `u = Γ k`, which turns the coefficients `α`, `Γ`,
/// `b` into `a = α Γ⁻¹`, `c = diag(1/γ) − Γ⁻¹`, `m = b Γ⁻¹`. Rows and weights beyond
/// [`stages`](Self::stages) are zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tableau {
    /// Number of stages.
    pub stages: usize,
    /// Order with the exact Jacobian.
    pub order: Order,
    /// Order with any matrix in place of the Jacobian, if it has one.
    pub order_of_any_matrix: Option<Order>,
    /// `γ`: `τ = γh`.
    pub gamma: f64,
    /// `a`, strictly lower triangular.
    pub a: Matrix,
    /// `c`, strictly lower triangular.
    pub c: Matrix,
    /// `m`.
    pub m: Row,
    /// `α_i = Σ_j α_ij`: the times of the stages in units of `h`.
    pub nodes: Row,
}

impl Tableau {
    /// Whether the forces of a stage are those of the stage before.
    pub fn repeats_forces(&self, stage: usize) -> bool {
        stage > 0 && self.a[stage] == self.a[stage - 1]
    }

    /// Whether the method keeps its order with any matrix in place of the Jacobian: a W-method.
    pub fn is_w_method(&self) -> bool {
        self.order_of_any_matrix == Some(self.order)
    }

    /// `α`, `Γ` and `b` of the definition.
    pub const fn definition(&self) -> (Matrix, Matrix, Row) {
        // Γ⁻¹ = diag(1/γ) − c
        let (mut inverse, mut i) = ([[0.0; STAGES]; STAGES], 0);
        while i < STAGES {
            let mut j = 0;
            while j < i {
                inverse[i][j] = -self.c[i][j];
                j += 1;
            }
            inverse[i][i] = 1.0 / self.gamma;
            i += 1;
        }
        let gamma = invert(&inverse);
        let b = multiply_row(&self.m, &gamma);
        (multiply(&self.a, &gamma), gamma, b)
    }

    /// From `α`, the strictly lower part of `Γ`, its diagonal and `b`.
    const fn new(
        (order, order_of_any_matrix): (Order, Option<Order>),
        alpha: &[&[f64]],
        gammas: &[&[f64]],
        gamma: f64,
        b: &[f64],
    ) -> Self {
        let (alpha, mut matrix, mut i) = (rows(alpha), rows(gammas), 0);
        while i < STAGES {
            matrix[i][i] = gamma;
            i += 1;
        }
        let inverse = invert(&matrix);
        let (mut c, mut i) = ([[0.0; STAGES]; STAGES], 0);
        while i < STAGES {
            let mut j = 0;
            while j < i {
                c[i][j] = -inverse[i][j];
                j += 1;
            }
            i += 1;
        }
        Self {
            stages: b.len(),
            order,
            order_of_any_matrix,
            gamma,
            a: multiply(&alpha, &inverse),
            c,
            m: multiply_row(&row(b), &inverse),
            nodes: sums(&alpha),
        }
    }
}

/// Rows from the second one on; the first stage has none.
const fn rows(short: &[&[f64]]) -> Matrix {
    let (mut all, mut i) = ([[0.0; STAGES]; STAGES], 0);
    while i < short.len() {
        all[i + 1] = row(short[i]);
        i += 1;
    }
    all
}

const fn row(short: &[f64]) -> Row {
    let (mut all, mut j) = ([0.0; STAGES], 0);
    while j < short.len() {
        all[j] = short[j];
        j += 1;
    }
    all
}

/// The sum of each row.
const fn sums(matrix: &Matrix) -> Row {
    let (mut out, mut i) = ([0.0; STAGES], 0);
    while i < STAGES {
        let mut j = 0;
        while j < STAGES {
            out[i] += matrix[i][j];
            j += 1;
        }
        i += 1;
    }
    out
}

/// `row · matrix`.
const fn multiply_row(row: &Row, matrix: &Matrix) -> Row {
    let (mut out, mut i) = ([0.0; STAGES], 0);
    while i < STAGES {
        let mut j = 0;
        while j < STAGES {
            out[j] += row[i] * matrix[i][j];
            j += 1;
        }
        i += 1;
    }
    out
}

const fn multiply(left: &Matrix, right: &Matrix) -> Matrix {
    let (mut out, mut i) = ([[0.0; STAGES]; STAGES], 0);
    while i < STAGES {
        out[i] = multiply_row(&left[i], right);
        i += 1;
    }
    out
}

/// The inverse of a lower triangular matrix, column by column.
const fn invert(lower: &Matrix) -> Matrix {
    let (mut out, mut column) = ([[0.0; STAGES]; STAGES], 0);
    while column < STAGES {
        let mut i = column;
        while i < STAGES {
            let mut sum = if i == column { 1.0 } else { 0.0 };
            let mut j = column;
            while j < i {
                sum -= lower[i][j] * out[j][column];
                j += 1;
            }
            out[i][column] = sum / lower[i][i];
            i += 1;
        }
        column += 1;
    }
    out
}

/// Which tableau.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// ROS2.
    Ros2,
    /// ROS3P.
    Ros3p,
    /// RODAS3.
    Rodas3,
    /// ROS34PW2.
    Ros34pw2,
    /// RODAS.
    Rodas4,
}

impl Word for Scheme {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("ros2", Self::Ros2),
        ("ros3p", Self::Ros3p),
        ("rodas3", Self::Rodas3),
        ("ros34pw2", Self::Ros34pw2),
        ("rodas4", Self::Rodas4),
    ];
}

impl Scheme {
    /// All tableaux.
    pub const ALL: [Self; 5] =
        [Self::Ros2, Self::Ros3p, Self::Rodas3, Self::Ros34pw2, Self::Rodas4];

    /// Its coefficients.
    pub const fn tableau(self) -> &'static Tableau {
        match self {
            Self::Ros2 => &ROS2,
            Self::Ros3p => &ROS3P,
            Self::Rodas3 => &RODAS3,
            Self::Ros34pw2 => &ROS34PW2,
            Self::Rodas4 => &RODAS4,
        }
    }
}

const ROS2_GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// ROS2: order 2 with any matrix, L-stable.
#[doc(alias = "Verwer-Spee-Blom-Hundsdorfer 1999")]
pub static ROS2: Tableau = Tableau::new(
    (Order::Two, Some(Order::Two)),
    &[&[1.0]],
    &[&[-2.0 * ROS2_GAMMA]],
    ROS2_GAMMA,
    &[0.5, 0.5],
);

/// `½ + √3/6`.
const ROS3P_GAMMA: f64 = 0.788_675_134_594_812_9;

/// ROS3P: order 3, A-stable with `|R(∞)| = √3 − 1`. Its last two stages share their forces.
#[doc(alias = "Lang-Verwer 2001")]
pub static ROS3P: Tableau = Tableau::new(
    (Order::Three, None),
    &[&[1.0], &[1.0, 0.0]],
    &[&[-1.0], &[-ROS3P_GAMMA, 0.5 - 2.0 * ROS3P_GAMMA]],
    ROS3P_GAMMA,
    &[2.0 / 3.0, 0.0, 1.0 / 3.0],
);

/// RODAS3: order 3, L-stable. Its first two stages share their forces.
#[doc(alias = "Sandu et al. 1997")]
pub static RODAS3: Tableau = Tableau::new(
    (Order::Three, None),
    &[&[0.0], &[1.0, 0.0], &[0.75, -0.25, 0.5]],
    &[&[1.0], &[-0.25, -0.25], &[1.0 / 12.0, 1.0 / 12.0, -2.0 / 3.0]],
    0.5,
    &[5.0 / 6.0, -1.0 / 6.0, -1.0 / 6.0, 0.5],
);

/// ROS34PW2: order 3 with any matrix, L-stable.
#[doc(alias = "Rang-Angermann 2005")]
pub static ROS34PW2: Tableau = Tableau::new(
    (Order::Three, Some(Order::Three)),
    &[
        &[0.871_733_043_016_918_01],
        &[0.844_570_600_153_694_23, -0.112_990_642_364_841_85],
        &[0.0, 0.0, 1.0],
    ],
    &[
        &[-0.871_733_043_016_918_01],
        &[-0.903_380_570_130_440_82, 0.054_180_672_388_095_326],
        &[0.242_123_807_060_953_46, -1.223_250_583_904_514_7, 0.545_260_255_335_102_14],
    ],
    0.435_866_521_508_458_999_42,
    &[
        0.242_123_807_060_953_46,
        -1.223_250_583_904_514_7,
        1.545_260_255_335_102,
        0.435_866_521_508_459,
    ],
);

const RODAS4_LAST: [f64; 4] =
    [1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895_0];

/// RODAS: order 4, L-stable. It is published in this form.
#[doc(alias = "RODAS")]
#[doc(alias = "Hairer-Wanner")]
pub static RODAS4: Tableau = {
    let [a51, a52, a53, a54] = RODAS4_LAST;
    Tableau {
        stages: 6,
        order: Order::Four,
        order_of_any_matrix: None,
        gamma: 0.25,
        a: rows(&[
            &[1.544],
            &[0.946_678_528_081_582_6, 0.255_701_169_898_328_4],
            &[3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7],
            &RODAS4_LAST,
            &[a51, a52, a53, a54, 1.0],
        ]),
        c: rows(&[
            &[-5.6688],
            &[-2.430_093_356_833_875, -0.206_359_915_709_191_5],
            &[-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16],
            &[
                7.496_443_313_967_647,
                -10.246_804_314_643_52,
                -33.999_903_528_199_05,
                11.708_908_932_061_60,
            ],
            &[
                8.083_246_795_921_522,
                -7.981_132_988_064_893,
                -31.521_594_328_743_71,
                16.319_305_431_231_36,
                -6.058_818_238_834_054,
            ],
        ]),
        m: [a51, a52, a53, a54, 1.0, 1.0],
        nodes: [0.0, 0.386, 0.21, 0.63, 1.0, 1.0],
    }
};
