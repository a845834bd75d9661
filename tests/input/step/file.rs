//! Writes STEP files (ISO 10303-21, AP214) of boxes as text.

use std::fmt::Write as _;

/// A box: its name, layers, two corners, and where the assembly puts it.
pub(super) struct Part {
    pub(super) name: &'static str,
    pub(super) layers: &'static [&'static str],
    pub(super) corners: [[f64; 3]; 2],
    pub(super) place: [f64; 3],
}

/// The numbered lines of a file.
#[derive(Default)]
struct Lines {
    text: String,
    count: usize,
}

impl Lines {
    /// Adds an entity and gives its number.
    fn add(&mut self, entity: &str) -> String {
        self.count += 1;
        writeln!(self.text, "#{}={entity};", self.count).unwrap();
        format!("#{}", self.count)
    }

    fn point(&mut self, at: [f64; 3]) -> String {
        self.add(&format!("CARTESIAN_POINT('',({:?},{:?},{:?}))", at[0], at[1], at[2]))
    }

    fn axes(&mut self, at: [f64; 3], z: [f64; 3], x: [f64; 3]) -> String {
        let [z, x] = [z, x].map(|v| self.add(&format!("DIRECTION('',({:?},{:?},{:?}))", v[0], v[1], v[2])));
        let at = self.point(at);
        self.add(&format!("AXIS2_PLACEMENT_3D('',{at},{z},{x})"))
    }

    fn product(&mut self, name: &str, contexts: &[String; 2], shape: &str) -> String {
        let product = self.add(&format!("PRODUCT('{name}','{name}','',({}))", contexts[0]));
        let version = self.add(&format!("PRODUCT_DEFINITION_FORMATION('','',{product})"));
        let definition = self.add(&format!("PRODUCT_DEFINITION('','',{version},{})", contexts[1]));
        let defined = self.add(&format!("PRODUCT_DEFINITION_SHAPE('','',{definition})"));
        self.add(&format!("SHAPE_DEFINITION_REPRESENTATION({defined},{shape})"));
        definition
    }

    /// The shell of a box with its sides outwards.
    fn shell(&mut self, [low, high]: [[f64; 3]; 2]) -> String {
        let is_high = |corner: usize, axis: usize| corner >> axis & 1 == 1;
        let place = |corner| [0, 1, 2].map(|axis| if is_high(corner, axis) { high[axis] } else { low[axis] });
        let points: Vec<String> = (0..8).map(|corner| self.point(place(corner))).collect();
        let mut faces = Vec::new();
        for axis in 0..3 {
            let (a, b) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            for side in 0..2 {
                let first = side << axis;
                let mut ring = [first, first | a, first | a | b, first | b];
                let (mut normal, mut along) = ([0.0; 3], [0.0; 3]);
                (normal[axis], along[(axis + 1) % 3]) = (1.0, 1.0);
                if side == 0 {
                    ring.reverse();
                    normal[axis] = -1.0;
                }
                let ring = ring.map(|corner| points[corner].as_str()).join(",");
                let ring = self.add(&format!("POLY_LOOP('',({ring}))"));
                let bound = self.add(&format!("FACE_OUTER_BOUND('',{ring},.T.)"));
                let axes = self.axes(place(first), normal, along);
                let plane = self.add(&format!("PLANE('',{axes})"));
                faces.push(self.add(&format!("FACE_SURFACE('',({bound}),{plane},.T.)")));
            }
        }
        self.add(&format!("CLOSED_SHELL('',({}))", faces.join(",")))
    }
}

/// What all shapes of a file need: the contexts of its products and of its shapes, and the frame of the file.
struct Basis {
    products: [String; 2],
    shapes: String,
    origin: String,
}

impl Lines {
    fn basis(&mut self, is_in_inches: bool) -> Basis {
        let application = self.add("APPLICATION_CONTEXT('automotive design')");
        let products = [
            self.add(&format!("PRODUCT_CONTEXT('',{application},'mechanical')")),
            self.add(&format!("PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")),
        ];
        let mut unit = self.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
        if is_in_inches {
            let dimensions = self.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)");
            let inch = self.add(&format!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),{unit})"));
            unit = self
                .add(&format!("(CONVERSION_BASED_UNIT('INCH',{inch})LENGTH_UNIT()NAMED_UNIT({dimensions}))"));
        }
        let angle = self.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
        let solid_angle = self.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
        let accuracy = self.add(&format!(
            "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-6),{unit},'distance_accuracy_value','')"
        ));
        let shapes = self.add(&format!(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({accuracy}))\
             GLOBAL_UNIT_ASSIGNED_CONTEXT(({unit},{angle},{solid_angle}))REPRESENTATION_CONTEXT('',''))"
        ));
        Basis { products, shapes, origin: self.axes([0.0; 3], UP, ALONG) }
    }

    fn solid(&mut self, Part { name, corners, .. }: &Part) -> String {
        let shell = self.shell(*corners);
        self.add(&format!("FACETED_BREP('{name}',{shell})"))
    }

    /// The layers of solids.
    fn layers(&mut self, parts: &[Part], solids: &[String]) {
        for (Part { layers, .. }, solid) in parts.iter().zip(solids) {
            for layer in *layers {
                self.add(&format!("PRESENTATION_LAYER_ASSIGNMENT('{layer}','',({solid}))"));
            }
        }
    }

    fn file(self) -> String {
        format!(
            "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('cell','2026-01-01T00:00:00',(''),(''),'','','');\n\
             FILE_SCHEMA(('AUTOMOTIVE_DESIGN {{ 1 0 10303 214 1 1 1 1 }}'));\nENDSEC;\nDATA;\n{}ENDSEC;\nEND-ISO-10303-21;\n",
            self.text
        )
    }
}

const UP: [f64; 3] = [0.0, 0.0, 1.0];
const ALONG: [f64; 3] = [1.0, 0.0, 0.0];

/// An assembly whose places of parts are all called NAUO1, as some CAD programs call them.
pub(super) fn assembly(is_in_inches: bool, parts: &[Part]) -> String {
    let mut lines = Lines::default();
    let Basis { products, shapes, origin } = lines.basis(is_in_inches);
    let places: Vec<String> = parts.iter().map(|part| lines.axes(part.place, UP, ALONG)).collect();
    let whole = lines.add(&format!("SHAPE_REPRESENTATION('cell',({origin},{}),{shapes})", places.join(",")));
    let cell = lines.product("cell", &products, &whole);
    let mut solids = Vec::new();
    for (part, place) in parts.iter().zip(&places) {
        let solid = lines.solid(part);
        let name = part.name;
        let shape =
            lines.add(&format!("FACETED_BREP_SHAPE_REPRESENTATION('{name}',({solid},{origin}),{shapes})"));
        solids.push(solid);
        let product = lines.product(name, &products, &shape);
        let usage = lines.add(&format!("NEXT_ASSEMBLY_USAGE_OCCURRENCE('NAUO1','','',{cell},{product},$)"));
        let usage = lines.add(&format!("PRODUCT_DEFINITION_SHAPE('','',{usage})"));
        let moved = lines.add(&format!("ITEM_DEFINED_TRANSFORMATION('','',{origin},{place})"));
        let relation = lines.add(&format!(
            "(REPRESENTATION_RELATIONSHIP('','',{shape},{whole})REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({moved})\
             SHAPE_REPRESENTATION_RELATIONSHIP())"
        ));
        lines.add(&format!("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{usage})"));
    }
    lines.layers(parts, &solids);
    lines.file()
}

/// One part with all solids, which are not moved, as drawing programs without assemblies write files.
pub(super) fn one_part(parts: &[Part]) -> String {
    let mut lines = Lines::default();
    let Basis { products, shapes, origin } = lines.basis(false);
    let solids: Vec<String> = parts.iter().map(|part| lines.solid(part)).collect();
    let shape = lines.add(&format!(
        "FACETED_BREP_SHAPE_REPRESENTATION('drawing',({},{origin}),{shapes})",
        solids.join(",")
    ));
    lines.product("drawing", &products, &shape);
    lines.layers(parts, &solids);
    lines.file()
}
