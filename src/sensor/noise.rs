//! The table that noise is drawn from: a normal distribution as equally likely whole numbers, made once a sensor on
//! the host. Which entry a ray draws is `march::draw`'s business.

use crate::march::NOISE_STEPS;
use crate::voxel::grid::{ONE_Q16, length_q16};

/// Largest standard deviation in voxels; a larger one would say nothing of any grid.
pub const MAX_STD_VOXELS: i64 = 64;

/// [`NOISE_STEPS`] deviations round(σ · Φ⁻¹((u + ½) / steps)) in 1/65536 voxels, rising; empty without noise.
pub fn table_q16(std_m: f64, voxel_size_m: f64) -> Vec<i32> {
    let std_q16 = length_q16(std_m, voxel_size_m).clamp(0, MAX_STD_VOXELS * ONE_Q16) as f64;
    if std_q16 == 0.0 {
        return Vec::new();
    }
    let share = |u: u32| (f64::from(u) + 0.5) / f64::from(NOISE_STEPS);
    (0..NOISE_STEPS).map(|u| (std_q16 * normal_quantile(share(u))).round() as i32).collect()
}

/// Φ⁻¹, the quantile of the standard normal distribution, to about 16 digits (Wichura, algorithm AS 241, PPND16).
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
    fn a_table_is_symmetric_and_has_its_standard_deviation() {
        let table = table_q16(0.06, 0.05);
        assert_eq!(table.len(), NOISE_STEPS as usize);
        assert!(table.is_sorted());
        assert!((0..table.len()).all(|u| table[u] == -table[table.len() - 1 - u]));
        let variance = table.iter().map(|&g| (g as f64).powi(2)).sum::<f64>() / table.len() as f64;
        let std_voxels = variance.sqrt() / 65_536.0;
        assert!((std_voxels - 1.2).abs() < 0.002, "{std_voxels}");
        assert!(table_q16(0.0, 0.05).is_empty());
    }

    #[test]
    fn a_huge_deviation_stays_in_32_bits() {
        let largest = *table_q16(1e300, 0.05).last().unwrap();
        assert!((64 * 3 * 65_536..64 * 4 * 65_536).contains(&largest), "{largest}");
    }
}
