//! The difference between a case and the plan.

/// What is different from what was planned.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Alteration {
    /// Nothing.
    #[default]
    None,
    /// Sensors that are dead, as in `camera:wall/1/0`.
    Dead(Vec<String>),
    /// Which draw of the mounts, counted from 0.
    Draw(u32),
    /// Who of the study's postures stands there instead of the scenes' people, as in `standing/0`.
    Posture(String),
}

impl Alteration {
    /// In words; nothing where nothing is different.
    pub fn words(&self) -> String {
        match self {
            Alteration::None => String::new(),
            Alteration::Dead(sensors) => format!("without {}", sensors.join(" and ")),
            Alteration::Draw(draw) => format!("draw {draw}"),
            Alteration::Posture(name) => format!("posture {name}"),
        }
    }

    /// Of what is planned and what is altered, that in which bodies come in. Entries stay where they are planned, also
    /// where mounts are off or a light curtain is dead; somebody of a posture is cover.
    pub fn where_bodies_come_in<T>(&self, planned: T, own: T) -> T {
        match self {
            Alteration::None | Alteration::Dead(_) | Alteration::Draw(_) => planned,
            Alteration::Posture(_) => own,
        }
    }
}
