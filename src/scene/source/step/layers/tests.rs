//! Groups of small files of which each shape is one line.

use super::*;

/// Parts: 10 and 11 are solids of one part with a frame, 20 of a part with two representations, 30 a surface of a shell,
/// 40 a solid without a layer, and 50 a copy of it.
const SHAPES: &str = "#1=AXIS2_PLACEMENT_3D('',#2,$,$);\n\
    #10=MANIFOLD_SOLID_BREP('',#12);#11=(GEOMETRIC_REPRESENTATION_ITEM()MANIFOLD_SOLID_BREP(#13));#12=CLOSED_SHELL('',(#14));\n\
    #15=ADVANCED_BREP_SHAPE_REPRESENTATION('two', (#1 ,#10,/*,*/#11), #9);\n\
    #20=FACETED_BREP('',#22);#24=SHAPE_REPRESENTATION('',(#1),#9);#25=FACETED_BREP_SHAPE_REPRESENTATION('',(#20),#9);\n\
    #26=SHAPE_REPRESENTATION_RELATIONSHIP('','',#24,#25);\n\
    #30=SHELL_BASED_SURFACE_MODEL('',(#31));#35=(REPRESENTATION('',(#30,#1),#9)SHAPE_REPRESENTATION());\n\
    #40=BREP_WITH_VOIDS('',#41,());#45=SHAPE_REPRESENTATION('',(#40),#9);\n\
    #50=MAPPED_ITEM('',#51,#1);#51=REPRESENTATION_MAP(#1,#45);#55=SHAPE_REPRESENTATION('',(#50),#9);\n\
    #60=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#61,#62);#70=REPRESENTATION('',(#10),#9);\n";

/// Which patterns match, the layers, and the items that are left in each list.
type Found = (Vec<bool>, Vec<String>, String);

/// The groups of a file, and the remarks.
fn groups(layers: &str, patterns: &[&str]) -> (Vec<Found>, Vec<String>) {
    let patterns: Vec<WildMatch> = patterns.iter().map(|pattern| WildMatch::new(pattern)).collect();
    let step = format!("{SHAPES}{layers}");
    let (groups, remarks) = split(step.as_bytes(), &patterns);
    let groups = groups.into_iter().map(|group| {
        let lists = File::read(&group.step).representations.into_iter();
        let lists: Vec<String> =
            lists.map(|list| list.items.iter().map(u64::to_string).collect::<Vec<_>>().join(" ")).collect();
        (group.matched, group.layers, lists.join("|"))
    });
    (groups.collect(), remarks)
}

#[test]
fn each_shape_is_in_the_group_of_its_layers() {
    let layers = "#80=PRESENTATION_LAYER_ASSIGNMENT('Fence left','',(#81,#24));#81=STYLED_ITEM('',(#82),#11);\n\
        #83=PRESENTATION_LAYER_ASSIGNMENT('Base','',(#84));\n\
        #84=(REPRESENTATION_ITEM('')STYLED_ITEM((#82),#31)OVER_RIDING_STYLED_ITEM(#85));\n\
        #86=PRESENTATION_LAYER_ASSIGNMENT('Base','',(#12));#87=PRESENTATION_LAYER_ASSIGNMENT('0','',(#10,#40,#20));";
    let all = "1 10 11|1|20|30 1|40|50";
    let (found, remarks) = groups(layers, &["Fence*", "B?se"]);
    let names = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
    let expected = [
        (vec![false, false], names(&["0"]), "1|1||1|40|50".to_string()),
        (vec![false, true], names(&["0", "Base"]), "1 10|1||30 1||50".into()),
        (vec![true, false], names(&["0", "Fence left"]), "1 11|1|20|1||50".into()),
    ];
    assert_eq!(found, expected);
    assert!(remarks.is_empty(), "{remarks:?}");
    let (one, _) = groups(layers, &["no such"]);
    assert_eq!(one, [(vec![false], names(&["0", "Base", "Fence left"]), all.into())]);
    let (one, _) = groups("", &["Fence*"]);
    assert_eq!(one, [(vec![false], vec![], all.into())]);
}

#[test]
fn shells_of_one_model_on_different_layers_are_told() {
    let model = "#90=SHELL_BASED_SURFACE_MODEL('',(#91,#92));#95=SHAPE_REPRESENTATION('',(#90),#9);";
    let on = |layers: &str| groups(&format!("{model}{layers}"), &["A"]).1;
    let told = "with 1 surface model whose shells are on different layers: each follows the rules as a whole";
    assert_eq!(on("#80=PRESENTATION_LAYER_ASSIGNMENT('A','',(#91));"), [told]);
    let both =
        "#80=PRESENTATION_LAYER_ASSIGNMENT('A','',(#91));#81=PRESENTATION_LAYER_ASSIGNMENT('B','',(#92));";
    assert_eq!(on(both), [told]);
    assert_eq!(on("#80=PRESENTATION_LAYER_ASSIGNMENT('A','',(#91,#92));"), Vec::<String>::new());
    assert_eq!(on("#80=PRESENTATION_LAYER_ASSIGNMENT('A','',(#90));"), Vec::<String>::new());
}

#[test]
fn what_a_layer_has_besides_shapes_is_said() {
    // A copy, a face, a representation that has no shape, and no entity at all.
    let layers = "#80=PRESENTATION_LAYER_ASSIGNMENT('Fence','',(#50,#14,#55,#99,#10));\
        #81=PRESENTATION_LAYER_ASSIGNMENT('Points','',(#98));";
    let (found, remarks) = groups(layers, &["F*"]);
    assert_eq!(found.len(), 2);
    assert_eq!(found[1].2, "1 10|1||1||50");
    let expected = "without 4 items of layer \"Fence\" that are no whole solids or surfaces: assemblies, copies, faces or curves";
    assert_eq!(remarks, [expected]);
}

#[test]
fn all_but_the_lists_stays() {
    let layers = "#80=PRESENTATION_LAYER_ASSIGNMENT('Fence','',(#10));";
    let step = format!("{SHAPES}{layers}");
    let (groups, _) = split(step.as_bytes(), &[WildMatch::new("Fence")]);
    let expected = step
        .replace("(#1 ,#10,/*,*/#11)", "(#1,#10)")
        .replace("(#20)", "()")
        .replace("(#30,#1)", "(#1)")
        .replace("(#40)", "()");
    assert_eq!(String::from_utf8(groups[1].step.clone()).unwrap(), expected);
}
