//! Reads positions and indices out of a glTF's buffers. All bounds are checked once, when the view on the bytes is
//! made, and nothing is allocated.

use ::gltf::json::{
    Accessor, Index,
    accessor::{ComponentType, Type},
    validation::Checked,
};
use glam::DVec3;

use super::container::Container;

/// The elements of one accessor, all inside its buffer.
pub(super) struct Elements<'a> {
    /// From the first element on.
    bytes: &'a [u8],
    stride: usize,
    component: ComponentType,
    /// How many there are.
    pub(super) count: usize,
}

impl<'a> Elements<'a> {
    /// An accessor that a primitive names as its POSITION.
    pub(super) fn positions(container: &'a Container, index: Index<Accessor>) -> Result<Self, String> {
        let fits = |component, kind| component == ComponentType::F32 && kind == Type::Vec3;
        Self::new(container, index, "POSITION must be VEC3 of float", fits)
    }

    /// An accessor that a primitive names as its indices.
    pub(super) fn indices(container: &'a Container, index: Index<Accessor>) -> Result<Self, String> {
        let fits = |component, kind| {
            use ComponentType::{U8, U16, U32};
            matches!(component, U8 | U16 | U32) && kind == Type::Scalar
        };
        let rule = "indices must be SCALAR of unsigned byte, short or int";
        Self::new(container, index, rule, fits)
    }

    fn new(
        container: &'a Container,
        index: Index<Accessor>,
        rule: &str,
        fits: impl Fn(ComponentType, Type) -> bool,
    ) -> Result<Self, String> {
        let number = index.value();
        let place = |what: &str| format!("accessors[{number}]: {what}");
        let accessor = (container.root.accessors.get(number)).ok_or_else(|| place("no such"))?;
        let (component, kind) = match (&accessor.component_type, &accessor.type_) {
            (Checked::Valid(component), Checked::Valid(kind)) => (component.0, *kind),
            _ => return Err(place("unknown componentType or type")),
        };
        if !fits(component, kind) {
            return Err(place(rule));
        }
        if accessor.sparse.is_some() {
            return Err(place("sparse accessors are not read, export again without them"));
        }
        let view = (accessor.buffer_view.as_ref()).ok_or_else(|| {
            place("has no bufferView: if the meshes are compressed, export again without compression")
        })?;
        let view_number = view.value();
        let (view, stride) = container.view(view_number)?;

        let size = component.size() * kind.multiplicity();
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(format!(
                "bufferViews[{view_number}].byteStride = {stride}: elements have {size} bytes"
            ));
        }
        let offset = accessor.byte_offset.unwrap_or_default().0;
        // In u128 no product of the file's u64 can wrap.
        let needed = match accessor.count.0 {
            0 => u128::from(offset),
            n => u128::from(offset) + u128::from(n - 1) * stride as u128 + size as u128,
        };
        if needed > view.len() as u128 {
            return Err(format!(
                "accessors[{number}] needs {needed} bytes of bufferViews[{view_number}], which has {}",
                view.len()
            ));
        }
        Ok(Elements { bytes: &view[offset as usize..], stride, component, count: accessor.count.0 as usize })
    }

    /// Element `i < count` of a POSITION accessor.
    pub(super) fn position(&self, i: usize) -> DVec3 {
        let float = |axis: usize| {
            f64::from(f32::from_le_bytes(self.array(i * self.stride + size_of::<f32>() * axis)))
        };
        DVec3::new(float(0), float(1), float(2))
    }

    /// Element `i < count` of an indices accessor.
    pub(super) fn index(&self, i: usize) -> usize {
        let at = i * self.stride;
        match self.component.size() {
            1 => usize::from(self.bytes[at]),
            2 => usize::from(u16::from_le_bytes(self.array(at))),
            _ => u32::from_le_bytes(self.array(at)) as usize,
        }
    }

    fn array<const N: usize>(&self, at: usize) -> [u8; N] {
        std::array::from_fn(|byte| self.bytes[at + byte])
    }
}
