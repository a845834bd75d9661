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
        3.3871328727963666080,
        1.3314166789178437745e2,
        1.9715909503065514427e3,
        1.3731693765509461125e4,
        4.5921953931549871457e4,
        6.7265770927008700853e4,
        3.3430575583588128105e4,
        2.5090809287301226727e3,
    ],
    [
        1.0,
        4.2313330701600911252e1,
        6.8718700749205790830e2,
        5.3941960214247511077e3,
        2.1213794301586595867e4,
        3.9307895800092710610e4,
        2.8729085735721942674e4,
        5.2264952788528545610e3,
    ],
];

#[allow(clippy::excessive_precision, reason = "the coefficients as they are published")]
const SHOULDER: [[f64; 8]; 2] = [
    [
        1.42343711074968357734,
        4.63033784615654529590,
        5.76949722146069140550,
        3.64784832476320460504,
        1.27045825245236838258,
        2.41780725177450611770e-1,
        2.27238449892691845833e-2,
        7.74545014278341407640e-4,
    ],
    [
        1.0,
        2.05319162663775882187,
        1.67638483018380384940,
        6.89767334985100004550e-1,
        1.48103976427480074590e-1,
        1.51986665636164571966e-2,
        5.47593808499534494600e-4,
        1.05075007164441684324e-9,
    ],
];

#[allow(clippy::excessive_precision, reason = "the coefficients as they are published")]
const TAIL: [[f64; 8]; 2] = [
    [
        6.65790464350110377720,
        5.46378491116411436990,
        1.78482653991729133580,
        2.96560571828504891230e-1,
        2.65321895265761230930e-2,
        1.24266094738807843860e-3,
        2.71155556874348757815e-5,
        2.01033439929228813265e-7,
    ],
    [
        1.0,
        5.99832206555887937690e-1,
        1.36929880922735805310e-1,
        1.48753612908506148525e-2,
        7.86869131145613259100e-4,
        1.84631831751005468180e-5,
        1.42151175831644588870e-7,
        2.04426310338993978564e-15,
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
