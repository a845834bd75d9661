//! The difference between a case and the plan.

/// An alteration of the plan.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Alteration {
    /// None.
    #[default]
    None,
    /// Dead sensors, as in `camera:wall/1/0`.
    Dead(Vec<String>),
    /// A draw of the mounts, counted from 0.
    Draw(u32),
    /// A posture that replaces the scenes' people, as in `standing/0`.
    Posture(String),
}

impl Alteration {
    /// In words; empty without an alteration.
    pub fn words(&self) -> String {
        match self {
            Alteration::None => String::new(),
            Alteration::Dead(sensors) => format!("without {}", sensors.join(" and ")),
            Alteration::Draw(draw) => format!("draw {draw}"),
            Alteration::Posture(name) => format!("posture {name}"),
        }
    }

    /// The version, planned or altered, in which bodies enter. Entries are the planned ones even if mounts are shifted
    /// or a light curtain is dead; the person of a posture is cover.
    pub fn where_bodies_come_in<T>(&self, planned: T, own: T) -> T {
        match self {
            Alteration::None | Alteration::Dead(_) | Alteration::Draw(_) => planned,
            Alteration::Posture(_) => own,
        }
    }
}
