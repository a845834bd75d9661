//! Worlds written by hand, whose places are worked by hand.

use glam::DVec3;

use super::*;
use crate::objects::mesh::tests::{assert_closed, volume};

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder
}

/// What is read of `world.sdf` among these files.
fn read_as(files: &[(&str, &str)], geometry: GeometryUse) -> Result<SdfWorld, String> {
    let folder = folder(files);
    let path = folder.path().join("world.sdf");
    let file = SdfFile {
        path: path.clone(),
        geometry,
        models: vec![folder.path().join("models"), folder.path().join("more")],
    };
    load(&file, &Sources::from_main(&path), 0.001).map_err(|e| e.to_string())
}

fn read(world: &str) -> Result<SdfWorld, String> {
    read_as(&[("world.sdf", world)], GeometryUse::Collision)
}

fn world(inside: &str) -> String {
    format!("<?xml version='1.0'?><sdf version='1.9'><world name='w'>{inside}</world></sdf>")
}

/// A link with a box of 2 cm about its origin.
fn dot(link: &str, pose: &str) -> String {
    format!(
        "<link name='{link}'>{pose}<collision name='c'><geometry><box><size>0.02 0.02 0.02</size></box></geometry></collision></link>"
    )
}

/// Where the middle of each link's body is, by the names of the link and of what it is in.
fn places(world: &SdfWorld) -> BTreeMap<String, DVec3> {
    let middle = |node: &NodeMesh| {
        let (low, high) = node.mesh.bounds().unwrap();
        (node.names.join(" in "), (low + high) / 2.0)
    };
    world.links.iter().map(middle).collect()
}

#[track_caller]
fn assert_near(world: &SdfWorld, link: &str, expected: [f64; 3]) {
    let places = places(world);
    let found = *places.get(link).unwrap_or_else(|| panic!("no {link} in {places:?}"));
    assert!(
        (found - DVec3::from_array(expected)).length() < 1e-9,
        "{link} at {found}, expected {expected:?}"
    );
}

#[test]
fn bodies_are_closed_and_as_large_as_they_say() {
    let pi = std::f64::consts::PI;
    for (shape, expected) in [
        ("<box><size>1 2 3</size></box>", 6.0),
        ("<cylinder><radius>0.5</radius><length>2</length></cylinder>", pi * 0.25 * 2.0),
        ("<capsule><radius>0.5</radius><length>2</length></capsule>", pi * 0.25 * 2.0 + pi / 6.0),
        ("<sphere><radius>0.5</radius></sphere>", pi / 6.0),
        ("<ellipsoid><radii>0.5 1 2</radii></ellipsoid>", pi * 4.0 / 3.0),
    ] {
        let text = format!(
            "<model name='m'><link name='l'><collision name='c'><geometry>{shape}</geometry></collision></link></model>"
        );
        let read = read(&world(&text)).unwrap();
        let mesh = &read.links[0].mesh;
        assert_closed(mesh);
        assert!((volume(mesh) - expected).abs() < 0.01 * expected, "{shape}: {}", volume(mesh));
    }
    // A plane of 4 × 2 m that faces +x stands upright.
    let plane = "<model name='m'><link name='l'><collision name='c'><pose>0 0 1 0 0 0</pose><geometry><plane><normal>1 0 0</normal>\
                 <size>4 2</size></plane></geometry></collision></link></model>";
    let (low, high) = read(&world(plane)).unwrap().links[0].mesh.bounds().unwrap();
    assert!(
        (high - low - DVec3::new(0.0, 2.0, 4.0)).length() < 1e-9 && (high.z - 3.0).abs() < 1e-9,
        "{low} {high}"
    );
    let plain = plane.replace("<normal>1 0 0</normal><size>4 2</size>", "");
    let (low, high) = read(&world(&plain)).unwrap().links[0].mesh.bounds().unwrap();
    assert!((high - low - DVec3::new(1.0, 1.0, 0.0)).length() < 1e-9, "the format's default: {low} {high}");
}

#[test]
fn poses_compose_from_the_world_to_the_body() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let body = "<collision name='c'><pose>0 0 0.5 0 0 0</pose><geometry><sphere><radius>0.01</radius></sphere></geometry></collision>";
    let text = format!(
        "<model name='arm'><pose>10 0 0 0 0 {quarter}</pose><link name='low'><pose>1 0 0 0 0 0</pose>{body}</link>\
         <link name='tip'><pose relative_to='low' degrees='true'>2 0 0 0 90 0</pose>{body}</link>\
         <model name='hand'><pose>0 3 0 0 0 0</pose>{}</model></model>",
        dot("palm", "<pose rotation_format='quat_xyzw'>0 0 1 0 0 0 2</pose>")
    );
    let read = read(&world(&text)).unwrap();
    // The model is turned by 90° about z: its x is the world's y.
    assert_near(&read, "low in arm", [10.0, 1.0, 0.5]);
    // The tip is turned about its y: its z is the model's x.
    assert_near(&read, "tip in arm", [10.0, 3.5, 0.0]);
    assert_near(&read, "palm in hand in arm", [7.0, 0.0, 1.0]);
}

#[test]
fn poses_are_relative_to_links_joints_frames_and_models() {
    let text = format!(
        "<frame name='dock'><pose>5 0 0 0 0 0</pose></frame><frame name='shelf' attached_to='dock'><pose>0 1 0 0 0 0</pose></frame>\
         <model name='a'><pose relative_to='shelf'>0 0 1 0 0 0</pose>{}{}\
         <joint name='j' type='revolute'><pose>0 0 2 0 0 0</pose><parent>one</parent><child>two</child></joint>{}\
         <frame name='grip' attached_to='one'><pose>0 0 0 0 0 0</pose></frame></model>\
         <model name='b' placement_frame='handle'><pose relative_to='a::grip'>0 0 0 0 0 0</pose>\
         <frame name='handle'><pose>0 0 7 0 0 0</pose></frame>{}</model>\
         <model name='c'><pose relative_to='world'>1 1 1 0 0 0</pose>{}</model>\
         <model name='d'><pose relative_to='a'>0 0 9 0 0 0</pose>{}</model>",
        dot("one", "<pose>1 0 0 0 0 0</pose>"),
        dot("two", "<pose relative_to='one'>0 2 0 0 0 0</pose>"),
        dot("three", "<pose relative_to='j'>0 0 0 0 0 0</pose>"),
        dot("b", ""),
        dot("c", "<pose/>"),
        dot("d", ""),
    );
    let read = read(&world(&text)).unwrap();
    assert_near(&read, "one in a", [6.0, 1.0, 1.0]);
    assert_near(&read, "two in a", [6.0, 3.0, 1.0]);
    // A joint is at its child.
    assert_near(&read, "three in a", [6.0, 3.0, 3.0]);
    // The handle is at the grip.
    assert_near(&read, "b in b", [6.0, 1.0, -6.0]);
    assert_near(&read, "c in c", [1.0, 1.0, 1.0]);
    assert_near(&read, "d in d", [5.0, 1.0, 10.0]);
}

const STL: &str = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 2 0\nendloop\nendfacet\nendsolid s\n";

#[test]
fn models_are_included_from_folders_and_files() {
    let crate_ = format!(
        "<sdf version='1.6'><model name='crate'><pose>0 0 3 0 0 0</pose>{}</model></sdf>",
        dot("l", "")
    );
    let new = crate_.replace("0 0 3", "0 0 4");
    let mesh = "<sdf version='1.6'><model name='m'><link name='l'><collision name='c'><geometry><mesh><uri>model://part/part.stl</uri>\
                <scale>1 2 1</scale></mesh></geometry></collision></link></model></sdf>";
    let text = world(
        "<include><uri>model://crate</uri></include>\
         <include><uri>model://crate</uri><name>second</name><pose>1 0 0 0 0 0</pose></include>\
         <include><uri>model://part</uri></include><include><uri>beside/crate.sdf</uri><name>third</name></include>\
         <include><uri>model://plain</uri><name>fourth</name></include>\
         <model name='stack'><pose>0 8 0 0 0 0</pose><include merge='true'><uri>model://crate</uri><name>in</name></include>\
         <frame name='f' attached_to='l'/></model>\
         <model name='on'><pose relative_to='stack::f'>0 0 1 0 0 0</pose><link name='o'><collision name='c'><geometry><sphere>\
         <radius>0.1</radius></sphere></geometry></collision></link></model>\
         <include><uri>model://sun</uri></include><include><uri>https://fuel.gazebosim.org/1.0/x/models/Tree</uri></include>",
    );
    let config = "<model><sdf version='1.6'>model.sdf</sdf><sdf version='1.10'>new.sdf</sdf><sdf version='1.7'>no.sdf</sdf></model>";
    let files = [
        ("world.sdf", text.as_str()),
        ("models/crate/model.config", config),
        ("models/crate/model.sdf", &crate_),
        ("models/crate/new.sdf", &new),
        ("more/part/model.config", "<model><sdf>part.sdf</sdf></model>"),
        ("more/part/part.sdf", mesh),
        ("more/part/part.stl", STL),
        ("beside/crate.sdf", &crate_),
        ("models/plain/model.sdf", &crate_),
    ];
    let read = read_as(&files, GeometryUse::Collision).unwrap();
    assert_near(&read, "l in crate", [0.0, 0.0, 4.0]);
    assert_near(&read, "l in second", [1.0, 0.0, 0.0]);
    assert_near(&read, "l in m", [1.0, 2.0, 0.0]);
    assert_near(&read, "l in third", [0.0, 0.0, 3.0]);
    assert_near(&read, "l in fourth", [0.0, 0.0, 3.0]);
    assert_near(&read, "l in in in stack", [0.0, 8.0, 4.0]);
    assert_near(&read, "o in on", [0.0, 8.0, 5.0]);
    assert_eq!(
        read.warning().unwrap(),
        "is an SDF world of which this is left out: include https://fuel.gazebosim.org/1.0/x/models/Tree (not on this \
         machine), light"
    );
    let without = |name: &str| {
        let files: Vec<_> = files.iter().copied().filter(|(file, _)| *file != name).collect();
        read_as(&files, GeometryUse::Collision).unwrap_err()
    };
    let gone = without("more/part/part.stl");
    assert!(gone.contains("part.sdf: model \"m\": link \"l\": collision \"c\": model://part/part.stl is in none of the folders of models"), "{gone}");
    let gone = without("beside/crate.sdf");
    assert!(
        gone.contains("world.sdf: include: beside/crate.sdf = ") && gone.contains("cannot be read"),
        "{gone}"
    );
}

#[test]
fn what_is_left_out_is_counted() {
    let text = world(
        "<light name='a'/><light name='b'/><plugin name='p'/><gui/><physics name='f'/><actor name='x'/>\
         <model name='m'><plugin name='p'/><link name='l'><sensor name='s'/><collision name='c'><geometry><heightmap/></geometry>\
         </collision><collision name='d'><geometry><mesh><uri>a.dae</uri><submesh><name>q</name></submesh></mesh></geometry></collision>\
         <collision name='e'><geometry><empty/></geometry></collision>\
         <collision name='g'><geometry><sphere><radius>1</radius></sphere></geometry></collision></link></model>",
    );
    let read = read(&text).unwrap();
    let expected = "actor, heightmap geometry, light (2), plugin (2), sensor, submesh of a mesh";
    assert!(read.warning().unwrap().ends_with(expected), "{:?}", read.warning());
    let plain = world(&format!("<model name='m'>{}</model>", dot("l", "")));
    assert_eq!(self::read(&plain).unwrap().warning(), None);
    // Models without a world are one.
    let bare =
        format!("<sdf version='1.6'><model name='m'><pose>1 0 0 0 0 0</pose>{}</model></sdf>", dot("l", ""));
    assert_near(&self::read(&bare).unwrap(), "l in m", [1.0, 0.0, 0.0]);
    let drawn = plain.replace("collision", "visual");
    assert!(
        self::read(&drawn)
            .unwrap_err()
            .contains("no link has a body of that geometry: write geometry = \"visual\"")
    );
    assert_near(&read_as(&[("world.sdf", &drawn)], GeometryUse::Visual).unwrap(), "l in m", [0.0; 3]);
}

#[test]
fn what_is_wrong_is_named() {
    let good = world(&format!(
        "<model name='m'><pose>1 0 0 0 0 0</pose>{}</model>",
        dot("l", "<pose>0 0 1 0 0 0</pose>")
    ));
    let refused = |text: &str, expected: &str| {
        let error = read(text).expect_err(expected);
        assert!(error.contains("world.sdf: ") && error.contains(expected), "{error:?} lacks {expected:?}");
    };
    let changed = |from: &str, to: &str, expected: &str| {
        assert!(good.contains(from), "{from}");
        refused(&good.replacen(from, to, 1), expected);
    };
    read(&good).unwrap();
    refused("", "is empty");
    refused("<robot/>", "its root is <robot>: an SDF's is <sdf>");
    refused("<sdf><world name='a'/><world name='b'/></sdf>", "has several worlds");
    refused("<sdf/>", "no link has a body");
    changed(
        "0 0 1 0 0 0",
        "0 0 1 0 0",
        "world.sdf: model \"m\": link \"l\": pose = \"0 0 1 0 0\": must be six numbers",
    );
    changed("0 0 1 0 0 0", "0 0 one 0 0 0", "must be numbers from -1000000");
    changed("0 0 1 0 0 0", "0 0 nan 0 0 0", "must be numbers from -1000000");
    changed("<pose>0 0 1", "<pose rotation_format='quat_xyzw'>0 0 1", "must be seven numbers");
    changed("<pose>0 0 1", "<pose rotation_format='matrix'>0 0 1", "rotation_format must be");
    changed(
        "<pose>0 0 1",
        "<pose relative_to='n'>0 0 1",
        "model \"m\": a pose is relative to \"n\": there is no such link",
    );
    changed("<pose>0 0 1", "<pose relative_to='l'>0 0 1", "poses relative to \"l\" lead back to themselves");
    changed("<pose>1 0 0", "<pose relative_to='m'>1 0 0", "world: poses relative to \"m\" lead back");
    changed(
        "<model name='m'>",
        "<model name='m' placement_frame='f'>",
        "model \"m\": placement_frame = \"f\": there is no such",
    );
    changed("<link name='l'>", "<link>", "model \"m\": one of its <link>: must have a name");
    changed("<geometry>", "<geo>", "is no XML");
    changed(
        "<size>0.02 0.02 0.02</size>",
        "<size>0.02 0.02</size>",
        "collision \"c\": box.size = \"0.02 0.02\": must be 3 numbers",
    );
    changed("<size>0.02 0.02 0.02</size>", "<size>0.02 -1 0.02</size>", "must be 0, or 0.000001 m or more");
    changed("<box><size>0.02 0.02 0.02</size></box>", "<sphere/>", "sphere.radius = \"\": must be a number");
    changed(
        "<box><size>0.02 0.02 0.02</size></box>",
        "<plane><normal>0 0 0</normal></plane>",
        "plane.normal: must not be zero",
    );
    changed("<box><size>0.02 0.02 0.02</size></box>", "<mesh/>", "mesh: no uri");
    changed(
        "<box><size>0.02 0.02 0.02</size></box>",
        "<mesh><uri>package://a/b.stl</uri></mesh>",
        "package:// is not supported",
    );
    changed("<box><size>0.02 0.02 0.02</size></box>", "<mesh><uri>b.stl</uri></mesh>", "link \"l\": ");
    changed("<model name='m'>", "<include/><model name='m'>", "world: include: no uri");
    changed(
        "<model name='m'>",
        "<include><uri>model://no</uri></include><model name='m'>",
        "model://no is in none of the folders of models: name",
    );
    changed(
        "<model name='m'>",
        "<include><uri>world.sdf</uri></include><model name='m'>",
        "world.sdf: has no model to include",
    );
    // A file that includes itself has no end.
    let ring =
        format!("<sdf><model name='m'><include><uri>world.sdf</uri></include>{}</model></sdf>", dot("l", ""));
    refused(&ring, "does a file include itself?");
    for length in (0..good.len()).step_by(3) {
        let _ = read(&good[..length]);
    }
}

#[test]
fn models_stand_where_the_state_of_a_saved_world_has_them() {
    let text = world(&format!(
        "<model name='table'><pose>1 0 0 0 0 0</pose>{}{}<model name='lamp'><pose>0 0 1 0 0 0</pose>{}</model></model>\
         <model name='still'>{}</model><model name='free'><pose>0 7 0 0 0 0</pose>{}</model>\
         <state world_name='w'><sim_time>1 2</sim_time>\
         <model name='table'><pose>5 5 0 0 0 0</pose><scale>1 1 1</scale><link name='top'><pose>5 5 2 0 0 0</pose></link>\
         <model name='lamp'><pose>5 5 3 0 0 0</pose></model></model>\
         <model name='still'><pose>0 0 0 0 0 0</pose></model><model name='gone'><pose>9 9 9 0 0 0</pose></model>\
         <insertions><model name='new'/></insertions><light name='sun'/></state>",
        dot("top", "<pose>0 0 1 0 0 0</pose>"),
        dot("leg", ""),
        dot("bulb", ""),
        dot("s", ""),
        dot("f", ""),
    ));
    let folder = folder(&[("world.sdf", &text)]);
    let path = folder.path().join("world.sdf");
    let file = SdfFile { path: path.clone(), geometry: GeometryUse::Collision, models: Vec::new() };
    let sources = Sources::from_main(&path);
    let read = load(&file, &sources, 0.001).unwrap();
    assert_near(&read, "top in table", [5.0, 5.0, 2.0]);
    assert_near(&read, "leg in table", [5.0, 5.0, 0.0]);
    assert_near(&read, "bulb in lamp in table", [5.0, 5.0, 3.0]);
    assert_near(&read, "s in still", [0.0; 3]);
    assert_near(&read, "f in free", [0.0, 7.0, 0.0]);
    assert!(read.warning().unwrap().ends_with("left out: model inserted by state"), "{:?}", read.warning());
    let remarks = sources.take_remarks();
    assert!(remarks.len() == 1 && remarks[0].contains("with 2 models placed by its <state>"), "{remarks:?}");
}

#[test]
fn many_models_and_frames_take_little_time() {
    let begun = std::time::Instant::now();
    // Each model stands on the one before it, and so do its frames.
    let chained: String = (1..4_000)
        .map(|i| format!("<model name='m{i}'><pose relative_to='m{}::f'>0 0 0.001 0 0 0</pose><frame name='f'/></model>", i - 1))
        .collect();
    let crate_ = format!("<sdf version='1.6'><model name='crate'>{}</model></sdf>", dot("l", ""));
    let included: String =
        (0..1_000).map(|i| format!("<include><uri>model://crate</uri><name>c{i}</name></include>")).collect();
    let text =
        world(&format!("<model name='m0'><frame name='f'/>{}</model>{chained}{included}", dot("l", "")));
    let files = [("world.sdf", text.as_str()), ("models/crate/model.sdf", crate_.as_str())];
    assert_eq!(read_as(&files, GeometryUse::Collision).unwrap().links.len(), 1_001);
    assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
    // What a file includes is counted before it is copied.
    let links: String = (0..300).map(|i| format!("<link name='l{i}'/>")).collect();
    let crate_ = format!("<sdf version='1.6'><model name='crate'>{links}</model></sdf>");
    let files = [("world.sdf", text.as_str()), ("models/crate/model.sdf", crate_.as_str())];
    let refused = read_as(&files, GeometryUse::Collision).unwrap_err();
    assert!(
        refused.contains("has more than 250000 links, frames and bodies: include fewer models"),
        "{refused}"
    );
}

#[test]
fn bodies_without_extent_are_passed_over_and_plates_are_not() {
    let with = |shape: &str| {
        let body = format!("<collision name='d'><geometry>{shape}</geometry></collision>");
        read(&world(&format!(
            "<model name='m'>{}</model>",
            dot("l", "").replacen("<collision", &(body + "<collision"), 1)
        )))
    };
    for nothing in [
        "<sphere><radius>0</radius></sphere>",
        "<cylinder><radius>0</radius><length>1</length></cylinder>",
        "<box><size>0 0 1</size></box>",
        "<ellipsoid><radii>0 1 0</radii></ellipsoid>",
        "<plane><size>0 1</size></plane>",
    ] {
        let read = with(nothing).unwrap();
        assert_near(&read, "l in m", [0.0; 3]);
        assert!(read.warning().unwrap().ends_with("left out: body without extent"), "{:?}", read.warning());
    }
    let plate = with("<box><size>4 2 0</size></box>").unwrap();
    assert_eq!((plate.links[0].mesh.triangles.len(), plate.warning()), (24, None));
}

#[test]
fn worlds_are_read_as_gazebo_reads_them() {
    let good = world(&format!("<model name='m'><pose>1 2 3 0 0 0</pose>{}</model>", dot("l", "")));
    for (from, to) in [
        ("<world", "<!-- a -- b --><world"),
        ("<world name='w'>", "<world name='w'><gz:policies><gz:pose>9 9 9 0 0 0</gz:pose></gz:policies>"),
        ("<model name='m'>", "<model name='m' experimental:params='&'>"),
        ("<pose>1 2 3", "<gz:pose>9 9 9 0 0 0</gz:pose><pose>1 <!-- x --> 2 3"),
        ("<?xml", "\n\n<?xml"),
        ("<pose>1 2 3 0 0 0", "<pose rotation_format='quat_xyzw'>1 2 3 0 0 0 0"),
    ] {
        assert!(good.contains(from), "{from}");
        assert_near(&read(&good.replacen(from, to, 1)).unwrap(), "l in m", [1.0, 2.0, 3.0]);
    }
    assert_near(&read(&format!("\u{feff}{good}")).unwrap(), "l in m", [1.0, 2.0, 3.0]);
    let mesh = "<mesh><uri>meshes\\part.stl</uri></mesh>";
    let text = good.replacen("<box><size>0.02 0.02 0.02</size></box>", mesh, 1);
    let files = [("world.sdf", text.as_str()), ("meshes/part.stl", STL)];
    assert_near(&read_as(&files, GeometryUse::Collision).unwrap(), "l in m", [2.0, 3.0, 3.0]);
    let text = text.replacen("meshes", "model://part\\meshes", 1);
    let files = [("world.sdf", text.as_str()), ("more/part/meshes/part.stl", STL)];
    assert_near(&read_as(&files, GeometryUse::Collision).unwrap(), "l in m", [2.0, 3.0, 3.0]);
}
