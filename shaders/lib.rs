//! The files of this folder, as text. What each is for stands at its top, and how kernels are joined from
//! several of them in `src/march/backend/gpu/kernels.rs`.

/// A file of this folder.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// Its name without the ending.
    pub name: &'static str,
    /// What is in it.
    pub text: &'static str,
}

/// Makes of each line a [`Shader`].
macro_rules! shaders {
    ($($shader:ident = $name:literal;)*) => {
        $(
            #[doc = concat!("`", $name, ".wgsl`")]
            pub const $shader: Shader = Shader { name: $name, text: include_str!(concat!($name, ".wgsl")) };
        )*
    };
}

shaders! {
    BLOCKS = "blocks";
    CARVE_BOXES = "carve_boxes";
    CARVE_CROWDED = "carve_crowded";
    CARVE_NEAR = "carve_near";
    CARVE_RAYS = "carve_rays";
    CARVE_VOXELS = "carve_voxels";
    CAST = "cast";
    CAST_LISTED = "cast_listed";
    CAST_TILES = "cast_tiles";
    COMPLETION = "completion";
    COUNT = "count";
    DETECT = "detect";
    FIRST_HIT = "first_hit";
    FREED = "freed";
    FUSE = "fuse";
    INTEGERS = "integers";
    LAYER = "layer";
    LEFT = "left";
    MARCH = "march";
    OUTLINE = "outline";
    PLACEMENT = "placement";
    PROJECTION = "projection";
    PYRAMID = "pyramid";
    RAY_END = "ray_end";
    RUNS = "runs";
    SEE_TILES = "see_tiles";
    STATIC_HITS = "static_hits";
    TILES = "tiles";
    TYPES = "types";
}
