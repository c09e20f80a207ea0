//! The emitted source, against files that were read when they were checked in. After a change that
//! is meant, `WGSL_CPU_BLESS=1 cargo test -p wgsl-cpu --test golden` writes them anew; read the
//! difference.

use std::{env, fs, path::PathBuf};

use wgsl_cpu::translate::{Native, translate_with};

fn check(name: &str, natives: &[Native]) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let wgsl = fs::read_to_string(folder.join(name).with_extension("wgsl")).expect("the WGSL is there");
    let actual = translate_with(&wgsl, natives).unwrap_or_else(|error| panic!("{name}: {error}")).rust;
    let golden = folder.join(name).with_extension("rs");
    if env::var("WGSL_CPU_BLESS").as_deref() == Ok("1") {
        fs::write(&golden, &actual).expect("the golden file is writable");
        return;
    }
    let expected =
        fs::read_to_string(&golden).unwrap_or_else(|error| panic!("{}: {error}", golden.display()));
    let differs = actual.lines().zip(expected.lines()).position(|(actual, expected)| actual != expected);
    let line = differs.unwrap_or(actual.lines().count().min(expected.lines().count()));
    assert!(
        actual == expected,
        "{} differs from line {} on:\n{:?}, not\n{:?}",
        golden.display(),
        line + 1,
        actual.lines().nth(line),
        expected.lines().nth(line),
    );
}

#[test]
fn statements() {
    check("statements", &[]);
}

#[test]
fn expressions() {
    check("expressions", &[]);
}

#[test]
fn kernel() {
    check("kernel", &[]);
}

#[test]
fn native() {
    let natives = ["weight", "search"].map(|function| Native { function, path: "crate::by_hand" });
    check("native", &natives);
}
