//! The tables that noise is drawn from, made once a sensor on the host: a normal distribution of unit width
//! as equally likely whole numbers, and its width at each distance. `march` says which entry a ray draws.

use std::sync::LazyLock;

use perirobot_march::backend::Noise;
use perirobot_march::march::{MAX_STD_VOXELS, NOISE_STEPS};
use perirobot_march::voxel::grid::{ONE_Q16, length_q16};

/// The standard deviation of a measured distance of t metres: std_m + t · (per_m + t · per_m2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// What it is at any distance, in metres.
    pub std_m: f64,
    /// What a metre of distance adds, in metres.
    pub per_m: f64,
    /// What the square of the distance adds, in metres a square metre.
    pub per_m2: f64,
}

impl Deviation {
    /// Distances are exact.
    pub const NONE: Deviation = Deviation { std_m: 0.0, per_m: 0.0, per_m2: 0.0 };

    /// The standard deviation at a distance, in metres.
    pub fn at_m(&self, t_m: f64) -> f64 {
        self.std_m + t_m * (self.per_m + t_m * self.per_m2)
    }

    /// The same in 1/65536 voxels, at most [`MAX_STD_VOXELS`].
    pub(crate) fn at_q16(&self, t_m: f64, voxel_size_m: f64) -> u32 {
        length_q16(self.at_m(t_m), voxel_size_m).clamp(0, i64::from(MAX_STD_VOXELS) * ONE_Q16) as u32
    }
}

/// What chance does to the returns of a sensor with this range in voxels.
pub(crate) fn noise(deviation: &Deviation, dropout: f64, range_voxels: u32, voxel_size_m: f64) -> Noise {
    let middle_m = |voxels: u32| (f64::from(voxels) + 0.5) * voxel_size_m;
    let std_q16: Vec<u32> =
        (0..=range_voxels).map(|voxels| deviation.at_q16(middle_m(voxels), voxel_size_m)).collect();
    // Beyond what 32 bits hold, the float becomes the largest number.
    let lost_below = (dropout * 4_294_967_296.0).round() as u32;
    match std_q16.iter().all(|&std_q16| std_q16 == 0) {
        true => Noise { lost_below, ..Noise::default() },
        false => Noise { unit_q12: unit_q12().to_vec(), std_q16, lost_below },
    }
}

/// [`NOISE_STEPS`] deviations round(2¹² · Φ⁻¹((u + ½) / steps)), rising.
pub(crate) fn unit_q12() -> &'static [i32] {
    static UNIT: LazyLock<Vec<i32>> = LazyLock::new(|| {
        let share = |u: u32| (f64::from(u) + 0.5) / f64::from(NOISE_STEPS);
        (0..NOISE_STEPS).map(|u| (4096.0 * normal_quantile(share(u))).round() as i32).collect()
    });
    &UNIT
}

/// Φ⁻¹, the quantile of the standard normal distribution, to about 16 digits (Wichura, algorithm AS 241,
/// PPND16).
fn normal_quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180625 - q * q;
        return q * polynomial(&CENTRE[0], r) / polynomial(&CENTRE[1], r);
    }
    let tail = if q < 0.0 { p } else { 1.0 - p };
    let r = libm::sqrt(-libm::log(tail));
    let (r, [above, below]) = if r <= 5.0 { (r - 1.6, &SHOULDER) } else { (r - 5.0, &TAIL) };
    let magnitude = polynomial(above, r) / polynomial(below, r);
    if q < 0.0 { -magnitude } else { magnitude }
}

/// Horner's rule, the constant first.
fn polynomial(coefficients: &[f64; 8], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

#[allow(clippy::excessive_precision, reason = "the coefficients as they are published")]
const CENTRE: [[f64; 8]; 2] = [
    [
        3.3871328727963665,
        133.14166789178438,
        1971.5909503065513,
        13731.69376550946,
        45921.95393154987,
        67265.7709270087,
        33430.57558358813,
        2509.0809287301227,
    ],
    [
        1.0,
        42.31333070160091,
        687.1870074920579,
        5394.196021424751,
        21213.794301586597,
        39307.89580009271,
        28729.085735721943,
        5226.495278852854,
    ],
];

#[allow(clippy::excessive_precision, reason = "the coefficients as they are published")]
const SHOULDER: [[f64; 8]; 2] = [
    [
        1.4234371107496835,
        4.630337846156546,
        5.769497221460691,
        3.6478483247632045,
        1.2704582524523684,
        0.2417807251774506,
        0.022723844989269184,
        0.0007745450142783414,
    ],
    [
        1.0,
        2.053191626637759,
        1.6763848301838038,
        0.6897673349851,
        0.14810397642748008,
        0.015198666563616457,
        0.0005475938084995345,
        1.0507500716444169e-09,
    ],
];

#[allow(clippy::excessive_precision, reason = "the coefficients as they are published")]
const TAIL: [[f64; 8]; 2] = [
    [
        6.657904643501103,
        5.463784911164114,
        1.7848265399172913,
        0.29656057182850487,
        0.026532189526576124,
        0.0012426609473880784,
        2.7115555687434876e-05,
        2.0103343992922881e-07,
    ],
    [
        1.0,
        0.599832206555888,
        0.1369298809227358,
        0.014875361290850615,
        0.0007868691311456133,
        1.8463183175100548e-05,
        1.421511758316446e-07,
        2.0442631033899397e-15,
    ],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_tables() {
        // Published values: 97.5 %, 99.9 %, 1e-6, 1e-12.
        for (p, expected) in [
            (0.5, 0.0),
            (0.75, 0.674_489_750_196_081_7),
            (0.975, 1.959_963_984_540_054),
            (0.999, 3.090_232_306_167_813_5),
            (1e-6, -4.753_424_308_822_899),
            (1e-12, -7.034_483_825_301_13),
        ] {
            let found = normal_quantile(p);
            assert!((found - expected).abs() < 1e-12 * (1.0 + expected.abs()), "{p}: {found}");
        }
    }

    #[test]
    fn the_unit_table_is_symmetric_and_of_unit_width() {
        let table = unit_q12();
        assert_eq!(table.len(), NOISE_STEPS as usize);
        assert!(table.is_sorted());
        assert!((0..table.len()).all(|u| table[u] == -table[table.len() - 1 - u]));
        let variance = table.iter().map(|&z| f64::from(z).powi(2)).sum::<f64>() / table.len() as f64;
        assert!((variance.sqrt() / 4096.0 - 1.0).abs() < 0.002, "{variance}");
    }

    /// By hand: at the middle of voxel 40, t = 40.5 · 0.05 m = 2.025 m, σ = 0.01 + 0.004 · 2.025 + 0.002 ·
    /// 2.025² m = 0.02630125 m = 0.526025 voxels = 34,473.57 / 65,536.
    #[test]
    fn a_deviation_grows_with_distance() {
        let deviation = Deviation { std_m: 0.01, per_m: 0.004, per_m2: 0.002 };
        let noise = noise(&deviation, 0.25, 60, 0.05);
        assert_eq!((noise.std_q16.len(), noise.std_q16[40], noise.lost_below), (61, 34_474, 1 << 30));
        assert!(noise.std_q16.is_sorted() && noise.std_q16[0] == 13_240, "{}", noise.std_q16[0]);
        // 3.2 standard deviations, in whole numbers: 13,107 · 34,474 / 4096 = 110,315.12.
        assert_eq!(perirobot_march::march::step_q16(13_107, noise.std_q16[40]), 110_315);
    }

    #[test]
    fn without_noise_there_are_no_tables() {
        assert_eq!(noise(&Deviation::NONE, 0.0, 60, 0.05), Noise::default());
        let lossy = noise(&Deviation::NONE, 0.5, 60, 0.05);
        assert_eq!(lossy, Noise { lost_below: 1 << 31, ..Noise::default() });
        let all_but_all = f64::from_bits(1f64.to_bits() - 1);
        assert_eq!(noise(&Deviation::NONE, all_but_all, 60, 0.05).lost_below, u32::MAX);
    }

    #[test]
    fn a_huge_deviation_stays_in_32_bits() {
        let huge = noise(&Deviation { std_m: 1e300, per_m: 1e300, per_m2: 1e300 }, 0.0, 2047, 0.05);
        assert!(huge.std_q16.iter().all(|&std_q16| std_q16 == 64 << 16));
        let largest = perirobot_march::march::step_q16(*huge.unit_q12.iter().max().unwrap(), huge.std_q16[0]);
        assert!((64 * 3 * 65_536..64 * 4 * 65_536).contains(&largest), "{largest}");
    }
}
