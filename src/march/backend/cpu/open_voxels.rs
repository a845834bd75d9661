//! Voxels of which it is not decided whether rays enter them beyond their shortest range, found by where these rays come to
//! that range (`nearest_range`).

use crate::voxel::Window;

/// Open voxels, and for each place those that rays may enter which come to their shortest range there.
pub(super) struct OpenVoxels {
    /// Each with the box of the places where rays that enter it come to their shortest range, from the sensor.
    voxels: Vec<([i32; 3], [[f64; 3]; 2])>,
    /// Of places from the sensor's voxel, whose voxels are listed from one number to the next.
    window: Window,
    first: Vec<u32>,
    listed: Vec<u32>,
}

impl OpenVoxels {
    /// For places that are so far away at most.
    pub(super) fn new(voxels: Vec<([i32; 3], [[f64; 3]; 2])>, spread: f64) -> OpenVoxels {
        let box_of = |[low, high]: &[[f64; 3]; 2]| {
            let place = |at: &[f64; 3], by: f64| at.map(|x| (x + by).floor() as i32);
            Window::from_corners(place(low, -spread), place(high, spread))
        };
        let boxes: Vec<Window> = voxels.iter().map(|(_, towards)| box_of(towards)).collect();
        let window = boxes.iter().copied().reduce(|all, one| all.union(&one));
        let window = window.unwrap_or(Window::from_corners([0; 3], [-1; 3]));
        let each = || {
            let numbered = boxes.iter().zip(0u32..);
            numbered.flat_map(|(part, number)| places(part).map(move |place| (place, number)))
        };
        // Counts, then where each list ends; it grows downwards from there.
        let mut first = vec![0u32; window.volume() as usize + 1];
        each().for_each(|(place, _)| first[index(&window, place)] += 1);
        let mut end = 0;
        for count in &mut first {
            end += *count;
            *count = end;
        }
        let mut listed = vec![0; end as usize];
        for (place, number) in each() {
            let first = &mut first[index(&window, place)];
            *first -= 1;
            listed[*first as usize] = number;
        }
        OpenVoxels { voxels, window, first, listed }
    }

    /// The voxels that rays may enter which come to their shortest range so near to a place.
    pub(super) fn about(&self, place: [f64; 3], spread: f64) -> impl Iterator<Item = [i32; 3]> + '_ {
        let at = place.map(|x| x.floor() as i32);
        let listed = self.window.contains(at).then(|| {
            let index = index(&self.window, at);
            &self.listed[self.first[index] as usize..self.first[index + 1] as usize]
        });
        let voxels = listed.unwrap_or_default().iter().map(|&number| &self.voxels[number as usize]);
        let holds = move |[low, high]: &[[f64; 3]; 2]| {
            (0..3).all(|r| low[r] - spread <= place[r] && place[r] <= high[r] + spread)
        };
        voxels.filter(move |(_, towards)| holds(towards)).map(|&(voxel, _)| voxel)
    }
}

/// The voxels of a window.
fn places(window: &Window) -> impl Iterator<Item = [i32; 3]> + use<> {
    let (min, end) = (window.min, window.end());
    (min[2]..end[2])
        .flat_map(move |z| (min[1]..end[1]).flat_map(move |y| (min[0]..end[0]).map(move |x| [x, y, z])))
}

/// The number of a voxel of a window.
fn index(window: &Window, voxel: [i32; 3]) -> usize {
    let [x, y, z] = std::array::from_fn(|r| (voxel[r] - window.min[r]) as usize);
    (z * window.size[1] as usize + y) * window.size[0] as usize + x
}
