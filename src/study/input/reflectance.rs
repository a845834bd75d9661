//! How dark the objects of a study are: the shares of light that they reflect, in up to seven shades.

use crate::diagnostics::Place;
use crate::sensor::Sensor;
use perirobot_march::Result;
use perirobot_march::march::SHADES;
use perirobot_scene::objects::spec::SceneSpec;

/// The share of light that people reflect unless their object says otherwise: that of the black test piece which safety laser
/// scanners must detect (IEC 61496-3).
pub const PERSON_REFLECTANCE: f64 = 0.018;

/// Numbers the objects of all scenes by how dark they are, if any sensor's range depends on it: the shares of the shades, the
/// darkest first.
pub(super) fn shade(at: &Place, scenes: &mut [SceneSpec], sensors: &[Sensor]) -> Result<Vec<f64>> {
    let is_asked = |sensor: &Sensor| sensor.kind.range().is_some_and(|range| range.reflectance.is_given());
    if !sensors.iter().any(is_asked) {
        return Ok(Vec::new());
    }
    let mut shares: Vec<f64> = scenes
        .iter()
        .flat_map(|scene| &scene.objects)
        .filter_map(|object| object.reflectance)
        .chain([PERSON_REFLECTANCE])
        .collect();
    shares.sort_by(f64::total_cmp);
    shares.dedup();
    if shares.len() > SHADES {
        let listed = shares.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        return Err(at
            .says(format!("its objects have {} different values of reflectance: {listed}", shares.len()))
            .with_advice(format!(
                "at most {SHADES} can be distinguished, {PERSON_REFLECTANCE} of people who have none among them: give similar \
                 objects the same"
            )));
    }
    for object in scenes.iter_mut().flat_map(|scene| &mut scene.objects) {
        object.shade = object.reflectance.map_or(0, |share| number(&shares, share));
        object.person_shade = number(&shares, object.reflectance.unwrap_or(PERSON_REFLECTANCE));
    }
    Ok(shares)
}

/// The shade of a share of light; 0 where there is none.
pub(super) fn number(shares: &[f64], share: f64) -> u8 {
    shares.iter().position(|known| *known == share).map_or(0, |place| place as u8 + 1)
}
