//! What the translator refuses, and that it names the line.

use wgsl_cpu::translate::{TranslateError, translate};

/// Asserts that the line marked `// here` is refused with a message that contains `message`.
fn refused(wgsl: &str, message: &str) -> TranslateError {
    let line = wgsl.lines().position(|line| line.contains("// here")).expect("a line is marked") as u32 + 1;
    let error = translate(wgsl).expect_err(wgsl);
    assert_eq!(error.location().line, line, "{error}");
    let text = wgsl.lines().nth(line as usize - 1).expect("the line is there").trim();
    assert_eq!(error.location().text, text);
    assert!(error.to_string().contains(message), "{error}");
    assert!(error.to_string().contains(&format!("line {line}")), "{error}");
    error
}

fn unsupported(wgsl: &str, construct: &str) {
    let error = refused(wgsl, construct);
    assert!(matches!(error, TranslateError::Unsupported { .. }), "{error}");
}

fn invalid(wgsl: &str, message: &str) {
    let error = refused(wgsl, message);
    assert!(matches!(error, TranslateError::Validation { .. } | TranslateError::Parse { .. }), "{error}");
}

#[test]
fn what_is_not_wgsl() {
    invalid("fn f() {\n  let x = ; // here\n}", "expected expression");
    invalid("fn f() -> u32 {\n  return y; // here\n}", "no definition in scope");
    let unfinished = translate("fn f() -> u32 {").expect_err("no end");
    assert!(matches!(unfinished, TranslateError::Parse { .. }));
    assert_eq!(translate("").expect("an empty module").bindings.len(), 0);
}

#[test]
fn what_is_not_valid() {
    invalid("fn g() {}\nfn f(x: u32) -> u32 {\n  return x + 1.0; // here\n}", "");
    invalid("fn f(x: f32) -> u32 {\n  return 2.0 * x; // here\n}", "");
    invalid("var<private> x: array<u32>; // here", "");
}

#[test]
fn numbers_of_other_widths() {
    invalid("enable f16;  // here\nfn f(x: f16) -> f16 { return x; }", "f16");
    invalid("fn g() {}\nfn f(x: f64) -> f32 { return f32(x); } // here", "");
    invalid("fn g() {}\nfn f(x: i64) -> i32 { return i32(x); } // here", "");
}

#[test]
fn barriers_and_workgroup_memory() {
    unsupported("@compute @workgroup_size(64)\nfn main() {\n  workgroupBarrier(); // here\n}", "a barrier");
    unsupported("fn f() {\n  storageBarrier(); // here\n}", "a barrier");
    unsupported(
        "var<workgroup> tile: array<u32, 64>; // here\n@compute @workgroup_size(64)\nfn main() { tile[0] = 1u; }",
        "workgroup memory",
    );
}

#[test]
fn textures_and_overrides() {
    unsupported(
        "@group(0) @binding(0) var image: texture_2d<f32>; // here\n\
         fn f() -> vec4<f32> { return textureLoad(image, vec2(0), 0); }",
        "a texture",
    );
    unsupported(
        "\noverride SIZE: u32; // here\nfn f() -> u32 { return SIZE; }",
        "a pipeline override without a default",
    );
}

#[test]
fn entry_points() {
    unsupported(
        "@compute @workgroup_size(8, 8)\nfn main() {} // here",
        "a workgroup of more than one dimension",
    );
    unsupported(
        "override ROWS: u32 = 8u;\n@compute @workgroup_size(8, ROWS)\nfn main() {} // here",
        "a workgroup of more than one dimension",
    );
    unsupported(
        "override SIZE: u32 = 8u;\n@compute @workgroup_size(2u * SIZE)\nfn main() {} // here",
        "this size of a workgroup",
    );
    unsupported(
        "@compute @workgroup_size(8)\nfn main() {}\n@compute @workgroup_size(8)\nfn other() {} // here",
        "a second entry point",
    );
    unsupported(
        "@fragment\nfn main() -> @location(0) vec4<f32> { return vec4(0.0); } // here",
        "an entry point that is not @compute",
    );
    unsupported(
        "\n@group(1) @binding(0) var<storage, read> x: array<u32>; // here\nfn f() -> u32 { return x[0]; }",
        "a binding outside group 0",
    );
}

#[test]
fn aliases() {
    unsupported(
        "fn g(a: ptr<function, u32>, b: ptr<function, u32>) { *a = *b; }\nfn f() {\n  var x = 1u;\n  \
         g(&x, &x); // here\n}",
        "two pointers into one variable",
    );
    unsupported(
        "var<private> x: u32;\nfn g(a: ptr<private, u32>) { *a = x; }\nfn f() {\n  g(&x); // here\n}",
        "a pointer to a variable that the function also uses",
    );
}

#[test]
fn functions_that_wgsl_does_not_have_on_the_cpu() {
    unsupported("fn f(x: f32) -> f32 {\n  return dpdx(x); // here\n}", "a derivative");
}
