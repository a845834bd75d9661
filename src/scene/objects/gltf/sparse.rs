//! Finds the elements of a glTF's sparse accessor that are written out; all others are as in its buffer, or zero.

use std::cmp::Ordering;

use ::gltf::json::accessor::ComponentType;
use ::gltf::json::accessor::sparse::Sparse;
use ::gltf::json::validation::Checked;

use super::container::Container;
use perirobot_march::error::{Issue, Site};

/// The elements of a sparse accessor that are written out: which they are, in increasing order, and their numbers.
pub(super) struct Others<'a> {
    places: Packed<'a>,
    elements: &'a [u8],
    /// Bytes of an element.
    size: usize,
    count: usize,
}

/// Integers without a gap between them.
struct Packed<'a> {
    bytes: &'a [u8],
    component: ComponentType,
}

impl<'a> Others<'a> {
    /// Those of an accessor whose elements have `size` bytes, of which there are `most`.
    pub(super) fn new(
        container: &'a Container,
        sparse: &Sparse,
        size: usize,
        most: u64,
    ) -> Result<Self, Issue> {
        let component = match &sparse.indices.component_type {
            Checked::Valid(component) => component.0,
            Checked::Invalid => {
                return Err(Issue::says("must be unsigned byte, short or int").with_place("indices"));
            }
        };
        let count = sparse.count.0;
        let packed = |index: usize, offset: u64, size: usize| {
            let (view, _) = container.view(index)?;
            let needed = u128::from(offset) + u128::from(count) * size as u128;
            match needed > view.len() as u128 {
                true => Err(Issue::says(format!("needs {needed} bytes"))
                    .with_advice(format!("bufferViews[{index}] has {}", view.len()))),
                false => Ok(&view[offset as usize..]),
            }
        };
        let (indices, values) = (&sparse.indices, &sparse.values);
        let bytes = packed(indices.buffer_view.value(), indices.byte_offset.0, component.size());
        let places = Packed { bytes: bytes.map_err(|issue| issue.with_place("indices"))?, component };
        let elements = packed(values.buffer_view.value(), values.byte_offset.0, size);
        let elements = elements.map_err(|issue| issue.with_place("values"))?;
        let count = count as usize;
        let in_order = (1..count).all(|i| places.get(i - 1) < places.get(i));
        if !in_order || count.checked_sub(1).is_some_and(|last| places.get(last) as u64 >= most) {
            let rule = format!("must increase, and stay below its count of {most}");
            return Err(Issue::says(rule).with_place(Site::Subject("indices".into())));
        }
        Ok(Others { places, elements, size, count })
    }

    /// The bytes of element `i`, if it is one of these.
    pub(super) fn element(&self, i: usize) -> Option<&'a [u8]> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low.midpoint(high);
            match self.places.get(middle).cmp(&i) {
                Ordering::Less => low = middle + 1,
                Ordering::Greater => high = middle,
                Ordering::Equal => return Some(&self.elements[middle * self.size..][..self.size]),
            }
        }
        None
    }
}

impl Packed<'_> {
    fn get(&self, i: usize) -> usize {
        let size = self.component.size();
        self.bytes[i * size..][..size].iter().rev().fold(0, |sum, &byte| sum << 8 | usize::from(byte))
    }
}
