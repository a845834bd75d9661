//! Drawing shared by figures and the page: the paper, axes, rows of distributions and bars of scores.

pub(super) mod axis;
pub(super) mod bar;
pub(super) mod quartile_box;
pub(super) mod sheet;
