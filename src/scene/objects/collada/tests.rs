use super::*;
use crate::objects::mesh::tests::{assert_closed, volume};

/// A cube of edge 1 from the origin as quads; `primitive` may replace its faces.
const CUBE: &str = r##"<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimetre" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="cube"><mesh>
<source id="positions">
<float_array id="numbers" count="24">0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1</float_array>
<technique_common><accessor source="#numbers" count="8" stride="3"/></technique_common>
</source>
<vertices id="vertices"><input semantic="POSITION" source="#positions"/></vertices>
<polylist count="6"><input semantic="VERTEX" source="#vertices" offset="0"/><vcount>4 4 4 4 4 4</vcount>
<p>0 3 2 1 4 5 6 7 0 1 5 4 1 2 6 5 2 3 7 6 3 0 4 7</p></polylist>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node id="part"><instance_geometry url="#cube"/></node></visual_scene>
</library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>"##;

const NODE: &str = r##"<node id="part"><instance_geometry url="#cube"/></node>"##;

#[track_caller]
fn change(from: &str, to: &str) -> String {
    assert!(CUBE.contains(from), "{from}");
    CUBE.replacen(from, to, 1)
}

#[track_caller]
fn assert_spans(text: &str, low: [f64; 3], high: [f64; 3]) {
    let mesh = parse(text).unwrap().0;
    assert_closed(&mesh);
    assert!(volume(&mesh) > 0.0, "looks inward");
    let bounds = mesh.bounds().unwrap();
    assert!((bounds.0 - DVec3::from(low)).length() < 1e-12, "{bounds:?}");
    assert!((bounds.1 - DVec3::from(high)).length() < 1e-12, "{bounds:?}");
}

#[test]
fn the_unit_counts_and_the_up_axis_does_not() {
    assert_spans(CUBE, [0.0; 3], [0.01; 3]);
    assert_spans(&change("<unit name=\"centimetre\" meter=\"0.01\"/>", ""), [0.0; 3], [1.0; 3]);
    // A box that is not as high as wide shows that y stays y.
    let flat = change("<node id=\"part\">", "<node id=\"part\"><scale>100 200 300</scale>");
    assert_spans(&flat, [0.0; 3], [1.0, 2.0, 3.0]);
}

#[test]
fn what_is_up_is_told() {
    let up = |axis: &str| parse(&change("<up_axis>Y_UP</up_axis>", axis)).map(|(_, up)| up);
    let said = |axis: &str| up(&format!("<up_axis> {axis}\n</up_axis>"));
    assert_eq!(["X_UP", "Y_UP", "Z_UP"].map(|axis| said(axis).unwrap()), [Up::X, Up::Y, Up::Z]);
    assert_eq!(up("").unwrap(), Up::Y, "the format's own default");
    assert_eq!(said("UP").unwrap_err().to_string(), "<up_axis> = \"UP\": must be X_UP, Y_UP or Z_UP");
}

#[test]
fn transforms_multiply_in_their_order_down_the_tree() {
    let moved = |inside: &str| {
        let node = NODE.replace("<instance_geometry", &format!("{inside}<instance_geometry"));
        change(NODE, &node).replace("0.01", "1")
    };
    // Scaled, then turned (x → y, y → −x), then moved: the last one written comes first.
    let steps = "<translate>5 0 0</translate><rotate>0 0 2 90</rotate><scale>1 2 3</scale>";
    assert_spans(&moved(steps), [3.0, 0.0, 0.0], [5.0, 1.0, 3.0]);
    let matrix = "<matrix>0 -2 0 5  1 0 0 0  0 0 3 0  0 0 0 1</matrix>";
    assert_spans(&moved(matrix), [3.0, 0.0, 0.0], [5.0, 1.0, 3.0]);
    // A mirror still looks outward.
    assert_spans(&moved("<scale>-1 1 1</scale>"), [-1.0, 0.0, 0.0], [0.0, 1.0, 1.0]);
    let nested = "<node><translate>0 0 10</translate><node><scale>2 2 2</scale><instance_geometry url=\"#cube\"/>\
        </node></node>";
    assert_spans(&change(NODE, nested).replace("0.01", "1"), [0.0, 0.0, 10.0], [2.0, 2.0, 12.0]);
}

#[test]
fn a_geometry_may_stand_in_many_places() {
    let twice = format!("{NODE}<node><translate>0 0 3</translate><instance_node url=\"#part\"/></node>");
    let mesh = parse(&change(NODE, &twice).replace("0.01", "1")).unwrap().0;
    assert_closed(&mesh);
    assert_eq!(mesh.bounds().unwrap().1, DVec3::new(1.0, 1.0, 4.0));
    assert!((volume(&mesh) - 2.0).abs() < 1e-12);
}

#[test]
fn every_kind_of_face_gives_the_same_cube() {
    let begin = CUBE.find("<polylist").unwrap();
    let end = CUBE.find("</polylist>").unwrap() + "</polylist>".len();
    let (expected, _) = parse(CUBE).unwrap();
    let input = "<input semantic=\"NORMAL\" source=\"#normals\" offset=\"0\"/>\
        <input semantic=\"VERTEX\" source=\"#vertices\" offset=\"1\"/>";
    // Before each corner stands the index of its normal.
    let list = |corners: &[usize]| {
        let words: Vec<String> = corners.iter().map(|c| format!("9 {c}")).collect();
        format!("<p>{}</p>", words.join(" "))
    };
    let quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    let each = |order: fn([usize; 4]) -> Vec<usize>| -> String { quads.map(|q| list(&order(q))).concat() };
    let triangles: Vec<usize> = quads.iter().flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d]).collect();
    for (tag, lists) in [
        ("triangles", list(&triangles)),
        ("polygons", each(|q| q.to_vec())),
        ("trifans", each(|q| q.to_vec())),
        ("tristrips", each(|[a, b, c, d]| vec![a, b, d, c])),
    ] {
        let text = format!("{}<{tag} count=\"6\">{input}{lists}</{tag}>{}", &CUBE[..begin], &CUBE[end..]);
        let (mesh, _) = parse(&text).unwrap_or_else(|what| panic!("{tag}: {what}"));
        assert_closed(&mesh);
        assert_eq!(mesh.triangles.len(), expected.triangles.len(), "{tag}");
        assert!((volume(&mesh) - volume(&expected)).abs() < 1e-18, "{tag}");
    }
}

#[test]
fn elements_of_several_kinds_may_share_an_id() {
    let shared = ["cube", "positions", "numbers", "vertices", "scene", "part"];
    let text = shared.iter().fold(CUBE.to_string(), |text, id| {
        text.replace(&format!("id=\"{id}\""), "id=\"one\"").replace(&format!("\"#{id}\""), "\"#one\"")
    });
    assert_spans(&text, [0.0; 3], [0.01; 3]);
    // Of two of a kind the first.
    let twice = change("</library_visual_scenes>", "<visual_scene id=\"scene\"/></library_visual_scenes>");
    assert_spans(&twice, [0.0; 3], [0.01; 3]);
}

#[test]
fn what_turns_nothing_or_has_no_surface_refuses_no_file() {
    let curve =
        "</geometry><geometry id=\"curve\"><spline closed=\"false\"/></geometry></library_geometries>";
    let with_curve = change("</geometry></library_geometries>", curve);
    for text in [
        change("<node id=\"part\">", "<node id=\"part\"><rotate>0 0 0 0</rotate><rotate>0 0 0 -0</rotate>"),
        with_curve.replacen("<instance_geometry", "<instance_geometry url=\"#curve\"/><instance_geometry", 1),
        change("count=\"24\"", "count=\"21\""),
        change("<COLLADA", "<!-- made -- by hand --><COLLADA").replacen(
            NODE,
            &format!("<fx:note/>{NODE}"),
            1,
        ),
    ] {
        assert_spans(&text, [0.0; 3], [0.01; 3]);
    }
}

#[test]
fn what_is_wrong_is_named_by_its_line() {
    let loops = "<node id=\"part\"><instance_node url=\"#part\"/></node>";
    let doubling: String = (0..39)
        .map(|i| {
            format!("<node id=\"n{i}\">{}</node>", format!("<instance_node url=\"#n{}\"/>", i + 1).repeat(2))
        })
        .collect();
    let doubling = doubling + "<node id=\"n39\"/>";
    for (from, to, expected) in [
        ("COLLADA", "collada", "is no XML"),
        ("<asset>", "<asset><x>", "is no XML"),
        ("meter=\"0.01\"", "meter=\"0\"", "<unit meter = \"0\">: must be"),
        ("meter=\"0.01\"", "meter=\"nan\"", "<unit meter"),
        ("<scene><instance_visual_scene url=\"#scene\"/></scene>", "", "has no <scene>"),
        (
            "url=\"#scene\"",
            "url=\"#none\"",
            "line 15: url = \"#none\": the file has no <visual_scene> of that id",
        ),
        ("url=\"#cube\"", "url=\"other.dae#cube\"", "must be # and the id"),
        ("url=\"#cube\"", "", "line 13: url is missing"),
        ("url=\"#cube\"", "url=\"#vertices\"", "no <geometry> of that id"),
        ("1 1 1 0 1 1<", "1 1 1 0 1<", "line 6: its count is more than the 23 numbers"),
        ("1 1 1 0 1 1<", "1 1 1 0 nan 1<", "line 6: \"nan\" is no finite number"),
        ("1 1 1 0 1 1<", "1 1 1 0 1e999 1<", "is no finite number"),
        ("count=\"8\" stride=\"3\"", "count=\"9\" stride=\"3\"", "line 7: count = 9"),
        ("count=\"8\" stride=\"3\"", "count=\"8\"", "stride = 1"),
        ("stride=\"3\"", "stride=\"18446744073709551615\"", "line 7: count = 8"),
        ("offset=\"0\"", "offset=\"18446744073709551615\"", "must be a multiple of"),
        ("offset=\"0\"", "offset=\"-1\"", "must be a whole number"),
        ("3 0 4 7<", "3 0 4 8<", "line 10: position 8: there are 8"),
        ("3 0 4 7<", "3 0 4 -1<", "line 11: \"-1\" is no index"),
        ("3 0 4 7<", "3 0 4<", "<vcount> asks for more than the 23 corners"),
        ("3 0 4 7<", "3 0 4 7 0<", "<vcount> leaves 1 corners"),
        ("4 4 4 4 4 4<", "4 4 4 4 4 2 2<", ""),
        ("semantic=\"VERTEX\"", "semantic=\"NORMAL\"", "has no <input semantic=\"VERTEX\">"),
        ("semantic=\"POSITION\"", "semantic=\"NORMAL\"", "has no <input semantic=\"POSITION\">"),
        ("<mesh>", "<convex_mesh/><mesh>", ""),
        (NODE, "<node id=\"part\"/>", "has no triangle in its scene"),
        (NODE, "<node id=\"part\"><instance_controller url=\"#skin\"/></node>", "a skeleton poses the mesh"),
        (NODE, "<node><lookat>0 0 0 0 0 0 0 0 0</lookat></node>", "<lookat> in line 13: not supported"),
        (NODE, "<node><translate>0 0</translate></node>", "has 2 numbers: must be 3"),
        (NODE, "<node><rotate>0 0 0 90</rotate></node>", "turns about an axis that is zero"),
        (NODE, "<node><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 2</matrix></node>", "its last row must be"),
        (NODE, loops, "more than 256 levels"),
        (NODE, &doubling, "more than 256 levels or 100000 nodes"),
    ] {
        let outcome = parse(&change(from, to));
        if expected.is_empty() {
            assert!(outcome.is_ok(), "{to}: {outcome:?}");
            continue;
        }
        let what = outcome.expect_err(from);
        assert!(what.to_string().contains(expected), "{from}: {what:?} lacks {expected:?}");
    }
}

#[test]
fn every_cut_of_a_good_file_is_refused() {
    for length in 0..CUBE.len() {
        assert!(parse(&CUBE[..length]).is_err(), "cut at {length}");
    }
}

#[test]
fn numbers_that_are_read_again_and_again_are_refused() {
    // Each of 300 primitives has no corner, and all positions read for it; 40 nodes show them.
    let primitive =
        "<triangles><input semantic=\"VERTEX\" source=\"#vertices\" offset=\"0\"/><p/></triangles>";
    let places = NODE.repeat(40).replace(" id=\"part\"", "");
    let (numbers, count) = ("1 2 3 ".repeat(1000), "count=\"3000\"");
    let text = change("<polylist", &(primitive.repeat(300) + "<polylist"))
        .replace("0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1", &numbers)
        .replace("count=\"24\"", count)
        .replace(NODE, &places);
    let what = parse(&text).unwrap_err();
    assert!(
        what.to_string().starts_with("<float_array> in line 6: unfolds to far more than its size"),
        "{what}"
    );
}
