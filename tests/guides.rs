//! The guides know what the crate says, and the crate knows what the README says.

use std::{fs, path::Path};

use crate::layering::source_files;

/// What a message has between the things that it names. `rest` begins after the name of the macro.
fn fixed_parts(rest: &str) -> Vec<String> {
    let Some(message) = rest
        .trim_start()
        .strip_prefix('"')
        .and_then(|text| text.split('"').next())
    else {
        return Vec::new();
    };
    let on_one_line: Vec<&str> = message.split("\\\n").map(str::trim_start).collect();
    let pieces = on_one_line.concat();
    let pieces = pieces.split('{').enumerate();
    pieces
        .map(|(number, piece)| match piece.split_once('}') {
            Some((_, fixed)) if number > 0 => fixed.trim().to_owned(),
            _ => piece.trim().to_owned(),
        })
        .filter(|fixed| fixed.len() > 3)
        .collect()
}

#[test]
fn every_snippet_of_the_readme_compiles() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let readme = fs::read_to_string(tests.join("../README.md")).expect("the README is there");
    // Those that need a feature are no documentation tests: each is a file, which is part of the tests of that feature.
    let snippets = readme.split("```rust,ignore\n").skip(1);
    let snippets = snippets.map(|rest| rest.split("```").next().unwrap_or(rest));
    let mut expected: Vec<String> = snippets.map(str::to_owned).collect();
    let files = source_files(&tests.join("readme")).into_iter();
    let mut compiled: Vec<String> = files
        .map(|file| fs::read_to_string(file).expect("a readable source file"))
        .collect();
    expected.sort_unstable();
    compiled.sort_unstable();
    assert!(
        !expected.is_empty(),
        "there are no snippets, or this does not find them"
    );
    assert_eq!(compiled, expected);
}

#[test]
fn every_warning_is_in_the_guide_of_what_may_be_wrong() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let guide = fs::read_to_string(src.join("guides/troubleshooting.rs")).expect("the guide is there");
    let (mut warnings, mut missing) = (0, Vec::new());
    for file in source_files(&src) {
        let text = fs::read_to_string(&file).expect("a readable source file");
        for rest in text.split("warn!(").skip(1) {
            warnings += 1;
            let parts = fixed_parts(rest).into_iter();
            missing.extend(
                parts
                    .filter(|part| !guide.contains(part))
                    .map(|part| (file.clone(), part)),
            );
        }
    }
    assert!(warnings > 0, "there are no warnings, or this does not find them");
    assert!(missing.is_empty(), "{missing:#?}");
}
