//! The tableaux of the method.

use drape_integrator::{Order, Word};

/// Most stages of a tableau.
pub const STAGES: usize = 6;

/// An explicit and a diagonally implicit Runge–Kutta method on the same stages.
///
/// Row `i` of a tableau belongs to stage `i`. Rows and weights beyond [`stages`](Self::stages) are
/// zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tableau {
    /// Number of stages, the explicit first one included.
    pub stages: usize,
    /// Order on forces of any split.
    pub order: Order,
    /// `a^E`, strictly lower triangular.
    pub explicit: [[f64; STAGES]; STAGES],
    /// `a^I`, lower triangular. Its diagonal is 0 in the first stage and `γ` in all others.
    pub implicit: [[f64; STAGES]; STAGES],
    /// `b^E`.
    pub explicit_weights: [f64; STAGES],
    /// `b^I`.
    pub implicit_weights: [f64; STAGES],
    /// `c`, the times of the stages in units of `h`: the row sums of both tableaux.
    pub nodes: [f64; STAGES],
}

impl Tableau {
    /// `γ`, the diagonal of `a^I`: the length of each implicit stage in units of `h`.
    pub const fn gamma(&self) -> f64 {
        self.implicit[1][1]
    }

    /// `b^E_i − a^E_si`: what the end of a step adds to its last stage `s`. The implicit weights of
    /// every tableau here are its last row.
    pub fn corrections(&self) -> [f64; STAGES] {
        let last = &self.explicit[self.stages - 1];
        std::array::from_fn(|i| self.explicit_weights[i] - last[i])
    }

    /// Whether a later stage takes the implicit force of the first stage.
    pub fn takes_first_slope(&self) -> bool {
        self.implicit.iter().any(|row| row[0] != 0.0)
    }

    /// Whether a later stage or the end of the step takes the explicit force of this stage.
    pub fn takes_force(&self, stage: usize) -> bool {
        self.explicit_weights[stage] != 0.0 || self.explicit.iter().any(|row| row[stage] != 0.0)
    }

    const fn new(
        order: Order,
        explicit: &[&[f64]],
        implicit: &[&[f64]],
        [explicit_weights, implicit_weights]: [&[f64]; 2],
    ) -> Self {
        let explicit = rows(explicit);
        let (mut nodes, mut i) = ([0.0; STAGES], 0);
        while i < STAGES {
            let mut j = 0;
            while j < i {
                nodes[i] += explicit[i][j];
                j += 1;
            }
            i += 1;
        }
        Self {
            stages: implicit.len() + 1,
            order,
            explicit,
            implicit: rows(implicit),
            explicit_weights: row(explicit_weights),
            implicit_weights: row(implicit_weights),
            nodes,
        }
    }
}

/// Rows from the second one on; the first stage has none.
const fn rows(short: &[&[f64]]) -> [[f64; STAGES]; STAGES] {
    let (mut all, mut i) = ([[0.0; STAGES]; STAGES], 0);
    while i < short.len() {
        all[i + 1] = row(short[i]);
        i += 1;
    }
    all
}

const fn row(short: &[f64]) -> [f64; STAGES] {
    let (mut all, mut j) = ([0.0; STAGES], 0);
    while j < short.len() {
        all[j] = short[j];
        j += 1;
    }
    all
}

/// Which tableau.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pair {
    /// ARS(2,2,2).
    Ars222,
    /// ARS(4,4,3).
    Ars443,
    /// ARK3(2)4L\[2\]SA.
    Ark3,
    /// ARK4(3)6L\[2\]SA.
    Ark4,
}

impl Word for Pair {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("ars222", Self::Ars222),
        ("ars443", Self::Ars443),
        ("ark3", Self::Ark3),
        ("ark4", Self::Ark4),
    ];
}

impl Pair {
    /// All tableaux.
    pub const ALL: [Self; 4] = [Self::Ars222, Self::Ars443, Self::Ark3, Self::Ark4];

    /// Its coefficients.
    pub const fn tableau(self) -> &'static Tableau {
        match self {
            Self::Ars222 => &ARS222,
            Self::Ars443 => &ARS443,
            Self::Ark3 => &ARK3,
            Self::Ark4 => &ARK4,
        }
    }
}

/// `1 − 1/√2`.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// `1 − 1/(2γ)`.
const DELTA: f64 = 1.0 - 0.5 / GAMMA;

/// ARS(2,2,2): order 2, both parts end at the last stage, the implicit one is L-stable.
#[doc(alias = "Ascher-Ruuth-Spiteri 1997")]
pub static ARS222: Tableau = Tableau::new(
    Order::Two,
    &[&[GAMMA], &[DELTA, 1.0 - DELTA]],
    &[&[0.0, GAMMA], &[0.0, 1.0 - GAMMA, GAMMA]],
    [&[DELTA, 1.0 - DELTA], &[0.0, 1.0 - GAMMA, GAMMA]],
);

/// ARS(4,4,3): order 3, both parts end at the last stage, the implicit one is L-stable.
#[doc(alias = "Ascher-Ruuth-Spiteri 1997")]
pub static ARS443: Tableau = Tableau::new(
    Order::Three,
    &[
        &[1.0 / 2.0],
        &[11.0 / 18.0, 1.0 / 18.0],
        &[5.0 / 6.0, -5.0 / 6.0, 1.0 / 2.0],
        &[1.0 / 4.0, 7.0 / 4.0, 3.0 / 4.0, -7.0 / 4.0],
    ],
    &[
        &[0.0, 1.0 / 2.0],
        &[0.0, 1.0 / 6.0, 1.0 / 2.0],
        &[0.0, -1.0 / 2.0, 1.0 / 2.0, 1.0 / 2.0],
        &[0.0, 3.0 / 2.0, -3.0 / 2.0, 1.0 / 2.0, 1.0 / 2.0],
    ],
    [
        &[1.0 / 4.0, 7.0 / 4.0, 3.0 / 4.0, -7.0 / 4.0],
        &[0.0, 3.0 / 2.0, -3.0 / 2.0, 1.0 / 2.0, 1.0 / 2.0],
    ],
);

const ARK3_GAMMA: f64 = 1_767_732_205_903.0 / 4_055_673_282_236.0;
const ARK3_WEIGHTS: &[f64] = &[
    1_471_266_399_579.0 / 7_840_856_788_654.0,
    -4_482_444_167_858.0 / 7_529_755_066_697.0,
    11_266_239_266_428.0 / 11_593_286_722_821.0,
    ARK3_GAMMA,
];

/// ARK3(2)4L\[2\]SA: order 3, the implicit part is L-stable and ends at the last stage.
#[doc(alias = "Kennedy-Carpenter 2003")]
pub static ARK3: Tableau = Tableau::new(
    Order::Three,
    &[
        &[1_767_732_205_903.0 / 2_027_836_641_118.0],
        &[5_535_828_885_825.0 / 10_492_691_773_637.0, 788_022_342_437.0 / 10_882_634_858_940.0],
        &[
            6_485_989_280_629.0 / 16_251_701_735_622.0,
            -4_246_266_847_089.0 / 9_704_473_918_619.0,
            10_755_448_449_292.0 / 10_357_097_424_841.0,
        ],
    ],
    &[
        &[ARK3_GAMMA, ARK3_GAMMA],
        &[
            2_746_238_789_719.0 / 10_658_868_560_708.0,
            -640_167_445_237.0 / 6_845_629_431_997.0,
            ARK3_GAMMA,
        ],
        ARK3_WEIGHTS,
    ],
    [ARK3_WEIGHTS, ARK3_WEIGHTS],
);

const ARK4_WEIGHTS: &[f64] = &[
    82_889.0 / 524_892.0,
    0.0,
    15_625.0 / 83_664.0,
    69_875.0 / 102_672.0,
    -2_260.0 / 8_211.0,
    1.0 / 4.0,
];

/// ARK4(3)6L\[2\]SA: order 4, the implicit part is L-stable and ends at the last stage.
#[doc(alias = "Kennedy-Carpenter 2003")]
pub static ARK4: Tableau = Tableau::new(
    Order::Four,
    &[
        &[1.0 / 2.0],
        &[13_861.0 / 62_500.0, 6_889.0 / 62_500.0],
        &[
            -116_923_316_275.0 / 2_393_684_061_468.0,
            -2_731_218_467_317.0 / 15_368_042_101_831.0,
            9_408_046_702_089.0 / 11_113_171_139_209.0,
        ],
        &[
            -451_086_348_788.0 / 2_902_428_689_909.0,
            -2_682_348_792_572.0 / 7_519_795_681_897.0,
            12_662_868_775_082.0 / 11_960_479_115_383.0,
            3_355_817_975_965.0 / 11_060_851_509_271.0,
        ],
        &[
            647_845_179_188.0 / 3_216_320_057_751.0,
            73_281_519_250.0 / 8_382_639_484_533.0,
            552_539_513_391.0 / 3_454_668_386_233.0,
            3_354_512_671_639.0 / 8_306_763_924_573.0,
            4_040.0 / 17_871.0,
        ],
    ],
    &[
        &[1.0 / 4.0, 1.0 / 4.0],
        &[8_611.0 / 62_500.0, -1_743.0 / 31_250.0, 1.0 / 4.0],
        &[5_012_029.0 / 34_652_500.0, -654_441.0 / 2_922_500.0, 174_375.0 / 388_108.0, 1.0 / 4.0],
        &[
            15_267_082_809.0 / 155_376_265_600.0,
            -71_443_401.0 / 120_774_400.0,
            730_878_875.0 / 902_184_768.0,
            2_285_395.0 / 8_070_912.0,
            1.0 / 4.0,
        ],
        ARK4_WEIGHTS,
    ],
    [ARK4_WEIGHTS, ARK4_WEIGHTS],
);
