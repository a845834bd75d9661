//! Entities of texts that are written here, and of texts with errors.

use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

/// The entities of a text: the number of each, and its words as they are written.
fn entities(text: &[u8]) -> Vec<(u64, Vec<String>)> {
    let mut all = Vec::new();
    for_each_entity(text, |number, body| {
        let written = |(_, place): &Placed| String::from_utf8_lossy(&text[place.clone()]).into_owned();
        all.push((number, body.iter().map(written).collect()));
    });
    all
}

#[test]
fn strings_and_comments_hide_what_they_contain() {
    let text = b"ISO-10303-21;HEADER;FILE_NAME('#1=A();');ENDSEC;DATA;\n\
        #1=A('it''s; #2=B();',#2/* #3=C(); */,(.T.,$,*),-1.5E-3,\"0F\");\n#4\n=\n(A()B(#1));/*'*/#5=C('');ENDSEC;";
    let expected: [(u64, &[&str]); 3] = [
        (
            1,
            &[
                "A",
                "(",
                "'it''s; #2=B();'",
                ",",
                "#2",
                ",",
                "(",
                ".T.",
                ",",
                "$",
                ",",
                "*",
                ")",
                ",",
                "-1.5E-3",
                ",",
                "\"0F\"",
                ")",
            ],
        ),
        (4, &["(", "A", "(", ")", "B", "(", "#1", ")", ")"]),
        (5, &["C", "(", "''", ")"]),
    ];
    let expected = expected.map(|(number, words)| (number, words.iter().map(ToString::to_string).collect()));
    assert_eq!(entities(text), expected);
}

#[test]
fn records_have_arguments() {
    let mut found = Vec::new();
    for_each_entity(b"#1=A('x',(#2,(#3)),#4);#5=(A(#6,$)B()C((#7),#8));#9=$;#10=A(", |number, body| {
        for (keyword, record) in records(body) {
            let arguments = arguments(record).into_iter().map(|one| references(one).collect()).collect();
            found.push((number, keyword.to_vec(), arguments));
        }
    });
    let expected = [
        (1, &b"A"[..], vec![vec![], vec![2, 3], vec![4]]),
        (5, b"A", vec![vec![6], vec![]]),
        (5, b"B", vec![vec![]]),
        (5, b"C", vec![vec![7], vec![8]]),
    ];
    assert_eq!(found, expected.map(|(number, keyword, arguments)| (number, keyword.to_vec(), arguments)));
}

#[test]
fn strings_are_decoded() {
    for (written, expected) in [
        ("Zaun ''links''", "Zaun 'links'"),
        ("Schutzz\\X2\\00E4\\X0\\une", "Schutzzäune"),
        ("\\X2\\673A5B50\\X0\\ \\X4\\0001F600\\X0\\", "机子 😀"),
        ("\\X2\\D83DDE00\\X0\\", "😀"),
        ("\\X\\E9t\\S\\i \\PA\\a\\\\b", "été a\\b"),
        ("Zäune", "Zäune"),
        ("\\X2\\00E\\X0\\|\\X2\\00E4|\\Q\\|\\", "\\X2\\00E\\X0\\|\\X2\\00E4|\\Q\\|\\"),
    ] {
        assert_eq!(decode(written.as_bytes()), expected, "{written}");
    }
    assert_eq!(decode(b"\xe4"), "\u{fffd}");
}

/// Words of entities that are drawn, each also as it is written between others.
fn words(rng: &mut ChaCha8Rng) -> Vec<String> {
    let mut words = vec!["A".to_string(), "(".into()];
    for _ in 0..rng.random_range(0..9) {
        words.push(match rng.random_range(0..7) {
            0 => "'a;''=#1'".into(),
            1 => "'/* (\n'".into(),
            2 => format!("#{}", rng.random_range(0..99)),
            3 => "(".into(),
            4 => ")".into(),
            5 => "''".into(),
            _ => ".T.".into(),
        });
        words.push(",".into());
    }
    words.push(")".into());
    words
}

#[test]
fn drawn_texts_come_back_and_damaged_ones_do_no_harm() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    for _ in 0..300 {
        let expected: Vec<_> =
            (0..rng.random_range(0..4_u64)).map(|number| (number, words(&mut rng))).collect();
        let mut text = String::new();
        for (number, words) in &expected {
            let gap = |rng: &mut ChaCha8Rng| ["", " ", "/* '#9=;*/", "\r\n\t"][rng.random_range(0..4)];
            text += &format!("#{number}{}={}", gap(&mut rng), gap(&mut rng));
            words.iter().for_each(|word| text += &format!("{word}{}", gap(&mut rng)));
            text += ";";
        }
        assert_eq!(entities(text.as_bytes()), expected, "{text}");
        let mut damaged = text.into_bytes();
        for _ in 0..damaged.len().min(3) {
            let at = rng.random_range(0..damaged.len());
            damaged[at] = b"'()#;/*\\=,\xff\0"[rng.random_range(0..12)];
        }
        damaged.truncate(rng.random_range(0..=damaged.len()));
        for_each_entity(&damaged, |_, body| {
            for (_, record) in records(body) {
                assert!(references(record).count() <= record.len());
                for (token, _) in arguments(record).into_iter().flatten() {
                    let Token::Text(text) = token else { continue };
                    decode(text);
                }
            }
        });
    }
}
