//! Tables for a terminal: a module for each, with a function `render` that returns the text.

pub mod answer;
pub mod best;
pub mod cheapest;
pub mod choose;
pub mod distribution;
pub mod groups;
pub mod judge;
pub mod maxima;
pub mod moving_scenes;
pub mod placements;
pub mod places;
pub mod reasons;
pub mod scored_map;
pub mod separation;
pub mod speed;
