//! The coefficients of the pairs.

/// An explicit Runge–Kutta method with estimates of its own error.
#[derive(Debug)]
pub(super) struct Tableau {
    /// Row `s` gives the stage `s + 1` from the slopes before it; the first stage is the start.
    pub(super) a: &'static [&'static [f64]],
    /// Times of the stages, as shares of a step.
    pub(super) c: &'static [f64],
    /// Weights of the slopes in the step.
    pub(super) b: &'static [f64],
    /// The estimate of the error.
    pub(super) error: Estimate,
    /// The exponent by which an error changes the step: one over the order of the estimate, plus 1.
    pub(super) exponent: f64,
    /// Least and greatest factor from a step to the next.
    pub(super) factors: [f64; 2],
}

/// How the error of a step follows from its slopes.
#[derive(Debug)]
pub(super) enum Estimate {
    /// Weights of all slopes, the last of which is that at the end of the step.
    WithEnd(&'static [f64]),
    /// Two estimates, of order 5 and 3, combined as Hairer, Nørsett and Wanner do (II.10).
    Two {
        /// Weights of the slopes in the estimate of order 5.
        fifth: &'static [f64],
        /// Weights of the slopes 1, 9 and 12 in the formula of order 3.
        third: [f64; 3],
    },
}

impl Tableau {
    /// Number of evaluations of the slope before the end of a step.
    pub(super) fn stages(&self) -> usize {
        self.b.len()
    }
}

/// DOP853: Dormand and Prince's method of order 8, with the estimates of Hairer, Nørsett and Wanner,
/// *Solving Ordinary Differential Equations I* (2nd edition, 1993), section II.10.
pub(super) const DOP853: Tableau = Tableau {
    a: &[
        &[0.05260015195876773],
        &[0.0197250569845379, 0.0591751709536137],
        &[0.02958758547680685, 0.0, 0.08876275643042054],
        &[0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792],
        &[0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242],
        &[0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125],
        &[
            0.03709200011850479,
            0.0,
            0.0,
            0.17038392571223998,
            0.10726203044637328,
            -0.015319437748624402,
            0.008273789163814023,
        ],
        &[
            0.6241109587160757,
            0.0,
            0.0,
            -3.3608926294469414,
            -0.868219346841726,
            27.59209969944671,
            20.154067550477894,
            -43.48988418106996,
        ],
        &[
            0.47766253643826434,
            0.0,
            0.0,
            -2.4881146199716677,
            -0.590290826836843,
            21.230051448181193,
            15.279233632882423,
            -33.28821096898486,
            -0.020331201708508627,
        ],
        &[
            -0.9371424300859873,
            0.0,
            0.0,
            5.186372428844064,
            1.0914373489967295,
            -8.149787010746927,
            -18.52006565999696,
            22.739487099350505,
            2.4936055526796523,
            -3.0467644718982196,
        ],
        &[
            2.273310147516538,
            0.0,
            0.0,
            -10.53449546673725,
            -2.0008720582248625,
            -17.9589318631188,
            27.94888452941996,
            -2.8589982771350235,
            -8.87285693353063,
            12.360567175794303,
            0.6433927460157636,
        ],
    ],
    c: &[
        0.0,
        0.05260015195876773,
        0.0789002279381516,
        0.1183503419072274,
        0.2816496580927726,
        0.3333333333333333,
        0.25,
        0.3076923076923077,
        0.6512820512820513,
        0.6,
        0.8571428571428571,
        1.0,
    ],
    b: &[
        0.054293734116568765,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    ],
    error: Estimate::Two {
        fifth: &[
            0.01312004499419488,
            0.0,
            0.0,
            0.0,
            0.0,
            -1.2251564463762044,
            -0.4957589496572502,
            1.6643771824549864,
            -0.35032884874997366,
            0.3341791187130175,
            0.08192320648511571,
            -0.022355307863886294,
        ],
        third: [0.2440944881889764, 0.7338466882816118, 0.022058823529411766],
    },
    exponent: 1.0 / 8.0,
    factors: [0.333, 6.0],
};

/// The pair of order 5 with an estimate of order 4 of Tsitouras, *Runge–Kutta pairs of order 5(4)
/// satisfying only the first column simplifying assumption* (2011).
pub(super) const TSIT5: Tableau = Tableau {
    a: &[
        &[0.161],
        &[-0.008480655492356989, 0.335480655492357],
        &[2.8971530571054935, -6.359448489975075, 4.3622954328695815],
        &[5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525],
        &[
            5.86145544294642,
            -12.92096931784711,
            8.159367898576159,
            -0.071584973281401,
            -0.028269050394068383,
        ],
    ],
    c: &[0.0, 0.161, 0.327, 0.9, 0.9800255409045097, 1.0],
    b: &[
        0.09646076681806523,
        0.01,
        0.4798896504144996,
        1.379008574103742,
        -3.290069515436081,
        2.324710524099774,
    ],
    error: Estimate::WithEnd(&[
        -0.001780011052225777,
        -0.0008164344596567469,
        0.007880878010261995,
        -0.1447110071732629,
        0.5823571654525552,
        -0.45808210592918697,
        1.0 / 66.0,
    ]),
    exponent: 1.0 / 5.0,
    factors: [0.2, 10.0],
};
