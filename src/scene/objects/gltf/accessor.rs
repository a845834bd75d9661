//! Reads positions, indices and other numbers out of a glTF's buffers. All bounds are checked once, when the
//! view on the bytes is made, and nothing is allocated.

use ::gltf::json::{
    Accessor, Index,
    accessor::{ComponentType, Type},
    validation::Checked,
};
use glam::DVec3;

use super::container::Container;
use super::sparse::Others;
use perirobot_march::error::Issue;

/// The elements of one accessor, all inside its buffer.
pub(super) struct Elements<'a> {
    /// From the first element on; without any, all elements are zero.
    bytes: Option<&'a [u8]>,
    stride: usize,
    component: ComponentType,
    /// Some elements that are others than `bytes` has.
    other: Option<Others<'a>>,
    /// How many there are.
    pub(super) count: usize,
}

impl<'a> Elements<'a> {
    /// An accessor that a primitive names as its POSITION.
    pub(super) fn positions(container: &'a Container, index: Index<Accessor>) -> Result<Self, Issue> {
        let fits = |component, kind, _| component == ComponentType::F32 && kind == Type::Vec3;
        Self::new(container, index, "POSITION must be VEC3 of float", fits)
    }

    /// An accessor that a primitive names as its indices.
    pub(super) fn indices(container: &'a Container, index: Index<Accessor>) -> Result<Self, Issue> {
        let fits = |component, kind, _| {
            use ComponentType::{U8, U16, U32};
            matches!(component, U8 | U16 | U32) && kind == Type::Scalar
        };
        let rule = "indices must be SCALAR of unsigned byte, short or int";
        Self::new(container, index, rule, fits)
    }

    /// An accessor that a primitive names as JOINTS.
    pub(super) fn joints(container: &'a Container, index: Index<Accessor>) -> Result<Self, Issue> {
        let fits = |component, kind, _| {
            matches!(component, ComponentType::U8 | ComponentType::U16) && kind == Type::Vec4
        };
        Self::new(container, index, "JOINTS must be VEC4 of unsigned byte or short", fits)
    }

    /// An accessor that a primitive names as WEIGHTS.
    pub(super) fn weights(container: &'a Container, index: Index<Accessor>) -> Result<Self, Issue> {
        let fits = |component, kind, normalized| {
            use ComponentType::{F32, U8, U16};
            (component == F32 || (matches!(component, U8 | U16) && normalized)) && kind == Type::Vec4
        };
        let rule = "WEIGHTS must be VEC4 of float, or of normalized unsigned byte or short";
        Self::new(container, index, rule, fits)
    }

    /// Numbers of a kind as floats: times, translations, scales, matrices.
    pub(super) fn floats(
        container: &'a Container,
        index: Index<Accessor>,
        of: Type,
        rule: &str,
    ) -> Result<Self, Issue> {
        Self::new(container, index, rule, |component, kind, _| component == ComponentType::F32 && kind == of)
    }

    /// Quaternions of an animation, x y z w.
    pub(super) fn rotations(container: &'a Container, index: Index<Accessor>) -> Result<Self, Issue> {
        let fits = |component, kind, normalized| {
            use ComponentType::{F32, I8, I16, U8, U16};
            let fraction = matches!(component, I8 | U8 | I16 | U16) && normalized;
            (component == F32 || fraction) && kind == Type::Vec4
        };
        let rule = "a rotation's output must be VEC4 of float, or of normalized byte or short";
        Self::new(container, index, rule, fits)
    }

    /// Weights of morph targets over time.
    pub(super) fn blending(container: &'a Container, index: Index<Accessor>) -> Result<Self, Issue> {
        let fits = |component, kind, normalized| {
            use ComponentType::{F32, I8, I16, U8, U16};
            let fraction = matches!(component, I8 | U8 | I16 | U16) && normalized;
            (component == F32 || fraction) && kind == Type::Scalar
        };
        let rule = "weights must be SCALAR of float, or of normalized byte or short";
        Self::new(container, index, rule, fits)
    }

    fn new(
        container: &'a Container,
        index: Index<Accessor>,
        rule: &str,
        fits: impl Fn(ComponentType, Type, bool) -> bool,
    ) -> Result<Self, Issue> {
        let number = index.value();
        let place = |issue: Issue| issue.with_place(format!("accessors[{number}]"));
        let accessor = (container.root.accessors.get(number)).ok_or_else(|| place(Issue::says("no such")))?;
        let (component, kind) = match (&accessor.component_type, &accessor.type_) {
            (Checked::Valid(component), Checked::Valid(kind)) => (component.0, *kind),
            _ => return Err(place(Issue::says("unknown componentType or type"))),
        };
        if !fits(component, kind, accessor.normalized) {
            return Err(place(Issue::unsupported(rule)));
        }
        let size = component.size() * kind.multiplicity();
        let count = accessor.count.0;
        let of_sparse = |sparse| {
            Others::new(container, sparse, size, count).map_err(|issue| place(issue.with_place("sparse")))
        };
        let other = accessor.sparse.as_ref().map(of_sparse).transpose()?;
        let Some(view) = &accessor.buffer_view else {
            // A few bytes may stand for many elements here, which those who keep them pay for.
            if other.is_none() || u32::try_from(count).is_err() {
                return Err(place(
                    Issue::unsupported("has no bufferView")
                        .with_advice("if the meshes are compressed, export again without compression"),
                ));
            }
            return Ok(Elements { bytes: None, stride: size, component, other, count: count as usize });
        };
        let view_number = view.value();
        let (view, stride) = container.view(view_number)?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(Issue::value(
                format!("bufferViews[{view_number}].byteStride"),
                stride,
                format!("elements have {size} bytes"),
            ));
        }
        let offset = accessor.byte_offset.unwrap_or_default().0;
        // In u128 no product of the file's u64 can wrap.
        let needed = match count {
            0 => u128::from(offset),
            n => u128::from(offset) + u128::from(n - 1) * stride as u128 + size as u128,
        };
        if needed > view.len() as u128 {
            return Err(Issue::says(format!(
                "accessors[{number}] needs {needed} bytes of bufferViews[{view_number}], which has {}",
                view.len()
            )));
        }
        let bytes = Some(&view[offset as usize..]);
        Ok(Elements { bytes, stride, component, other, count: count as usize })
    }

    /// Element `i < count` of a POSITION accessor.
    pub(super) fn position(&self, i: usize) -> DVec3 {
        let float = |axis: usize| self.number(i, axis);
        DVec3::new(float(0), float(1), float(2))
    }

    /// Component `c` of element `i < count`: a float, or an integer as the fraction it stands for.
    pub(super) fn number(&self, i: usize, c: usize) -> f64 {
        match self.component {
            ComponentType::I8 => (f64::from(i8::from_le_bytes(self.array(i, c))) / 127.0).max(-1.0),
            ComponentType::U8 => f64::from(u8::from_le_bytes(self.array(i, c))) / 255.0,
            ComponentType::I16 => (f64::from(i16::from_le_bytes(self.array(i, c))) / 32_767.0).max(-1.0),
            ComponentType::U16 => f64::from(u16::from_le_bytes(self.array(i, c))) / 65_535.0,
            ComponentType::U32 => f64::from(u32::from_le_bytes(self.array(i, c))),
            ComponentType::F32 => f64::from(f32::from_le_bytes(self.array(i, c))),
        }
    }

    /// Element `i < count` of an indices accessor.
    pub(super) fn index(&self, i: usize) -> usize {
        self.index_of(i, 0)
    }

    /// Component `c` of element `i < count`, as an index.
    pub(super) fn index_of(&self, i: usize, c: usize) -> usize {
        match self.component.size() {
            1 => usize::from(u8::from_le_bytes(self.array(i, c))),
            2 => usize::from(u16::from_le_bytes(self.array(i, c))),
            _ => u32::from_le_bytes(self.array(i, c)) as usize,
        }
    }

    /// The bytes of component `c` of element `i`.
    fn array<const N: usize>(&self, i: usize, c: usize) -> [u8; N] {
        let at = c * self.component.size();
        let (bytes, at) = match (self.other.as_ref().and_then(|other| other.element(i)), self.bytes) {
            (Some(element), _) => (element, at),
            (None, Some(bytes)) => (bytes, i * self.stride + at),
            (None, None) => return [0; N],
        };
        std::array::from_fn(|byte| bytes[at + byte])
    }
}
