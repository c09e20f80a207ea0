//! What the format's schema says of a document, for those of its rules whose breach may show.
//!
//! Readers meet a breach in what they read, and refuse it; here the rest of the document is looked
//! over too, and what is wrong in it is listed. Rules that change nothing for a renderer (empty
//! lists, bounds that do not fit, alignment) are not looked at.

use serde_json::Value;

use super::json::escaped;
use crate::warning::{WarningKind, Warnings};

/// What is expected of a value.
enum Rule {
    /// An index into a list of the document.
    Index(&'static str),
    /// An index into a list of the object two levels up.
    Sibling(&'static str),
    /// Members that an object must have.
    Required(&'static [&'static str]),
    /// One of these numbers.
    OneOf(&'static [u64]),
    /// One of these words.
    Word(&'static [&'static str]),
    /// A number within these.
    Number(f64, f64),
    /// A whole number of at least this.
    Whole(u64),
    Text,
    Flag,
    /// So many numbers.
    Numbers(usize),
}

use Rule::{Flag, Index, Number, Numbers, OneOf, Required, Sibling, Text, Whole, Word};

const INFINITY: f64 = f64::INFINITY;

/// Where (`*` is any item or member) and what.
const RULES: &[(&str, Rule)] = &[
    ("", Required(&["asset"])),
    ("scene", Index("scenes")),
    ("extensionsUsed/*", Text),
    ("extensionsRequired/*", Text),
    ("asset", Required(&["version"])),
    ("asset/version", Text),
    ("asset/generator", Text),
    ("asset/copyright", Text),
    ("scenes/*/nodes/*", Index("nodes")),
    ("nodes/*/mesh", Index("meshes")),
    ("nodes/*/camera", Index("cameras")),
    ("nodes/*/skin", Index("skins")),
    ("nodes/*/children/*", Index("nodes")),
    ("nodes/*/matrix", Numbers(16)),
    ("nodes/*/rotation", Numbers(4)),
    ("nodes/*/rotation/*", Number(-1.0, 1.0)),
    ("nodes/*/scale", Numbers(3)),
    ("nodes/*/translation", Numbers(3)),
    ("nodes/*/name", Text),
    ("nodes/*/extensions/KHR_lights_punctual", Required(&["light"])),
    ("nodes/*/extensions/KHR_lights_punctual/light", Index("extensions/KHR_lights_punctual/lights")),
    ("meshes/*", Required(&["primitives"])),
    ("meshes/*/primitives/*", Required(&["attributes"])),
    ("meshes/*/primitives/*/attributes/*", Index("accessors")),
    ("meshes/*/primitives/*/indices", Index("accessors")),
    ("meshes/*/primitives/*/material", Index("materials")),
    ("meshes/*/primitives/*/mode", OneOf(&[0, 1, 2, 3, 4, 5, 6])),
    ("meshes/*/primitives/*/targets/*/*", Index("accessors")),
    ("meshes/*/primitives/*/extensions/KHR_materials_variants/mappings/*/material", Index("materials")),
    (
        "meshes/*/primitives/*/extensions/KHR_materials_variants/mappings/*/variants/*",
        Index("extensions/KHR_materials_variants/variants"),
    ),
    ("accessors/*", Required(&["componentType", "count", "type"])),
    ("accessors/*/bufferView", Index("bufferViews")),
    ("accessors/*/byteOffset", Whole(0)),
    ("accessors/*/count", Whole(1)),
    ("accessors/*/componentType", OneOf(&[5120, 5121, 5122, 5123, 5125, 5126])),
    ("accessors/*/type", Word(&["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"])),
    ("accessors/*/normalized", Flag),
    ("accessors/*/sparse", Required(&["count", "indices", "values"])),
    ("accessors/*/sparse/indices", Required(&["bufferView", "componentType"])),
    ("accessors/*/sparse/indices/bufferView", Index("bufferViews")),
    ("accessors/*/sparse/indices/componentType", OneOf(&[5121, 5123, 5125])),
    ("accessors/*/sparse/values", Required(&["bufferView"])),
    ("accessors/*/sparse/values/bufferView", Index("bufferViews")),
    ("bufferViews/*", Required(&["buffer", "byteLength"])),
    ("bufferViews/*/buffer", Index("buffers")),
    ("bufferViews/*/byteOffset", Whole(0)),
    ("bufferViews/*/byteLength", Whole(1)),
    ("bufferViews/*/byteStride", Number(4.0, 252.0)),
    ("bufferViews/*/target", OneOf(&[34962, 34963])),
    ("buffers/*", Required(&["byteLength"])),
    ("buffers/*/byteLength", Whole(1)),
    ("buffers/*/uri", Text),
    ("cameras/*", Required(&["type"])),
    ("cameras/*/type", Word(&["perspective", "orthographic"])),
    ("cameras/*/perspective", Required(&["yfov", "znear"])),
    ("cameras/*/perspective/yfov", Number(f64::MIN_POSITIVE, INFINITY)),
    ("cameras/*/perspective/znear", Number(f64::MIN_POSITIVE, INFINITY)),
    ("cameras/*/perspective/zfar", Number(f64::MIN_POSITIVE, INFINITY)),
    ("cameras/*/perspective/aspectRatio", Number(f64::MIN_POSITIVE, INFINITY)),
    ("cameras/*/orthographic", Required(&["xmag", "ymag", "zfar", "znear"])),
    ("images/*/bufferView", Index("bufferViews")),
    ("images/*/mimeType", Text),
    ("images/*/uri", Text),
    ("textures/*/sampler", Index("samplers")),
    ("textures/*/source", Index("images")),
    ("textures/*/extensions/*/source", Index("images")),
    ("samplers/*/magFilter", OneOf(&[9728, 9729])),
    ("samplers/*/minFilter", OneOf(&[9728, 9729, 9984, 9985, 9986, 9987])),
    ("samplers/*/wrapS", OneOf(&[10497, 33071, 33648])),
    ("samplers/*/wrapT", OneOf(&[10497, 33071, 33648])),
    ("materials/*/alphaMode", Word(&["OPAQUE", "MASK", "BLEND"])),
    ("materials/*/alphaCutoff", Number(0.0, INFINITY)),
    ("materials/*/doubleSided", Flag),
    ("materials/*/emissiveFactor", Numbers(3)),
    ("materials/*/emissiveFactor/*", Number(0.0, 1.0)),
    ("materials/*/pbrMetallicRoughness/baseColorFactor", Numbers(4)),
    ("materials/*/pbrMetallicRoughness/baseColorFactor/*", Number(0.0, 1.0)),
    ("materials/*/pbrMetallicRoughness/metallicFactor", Number(0.0, 1.0)),
    ("materials/*/pbrMetallicRoughness/roughnessFactor", Number(0.0, 1.0)),
    ("materials/*/occlusionTexture/strength", Number(0.0, 1.0)),
    ("skins/*", Required(&["joints"])),
    ("skins/*/inverseBindMatrices", Index("accessors")),
    ("skins/*/skeleton", Index("nodes")),
    ("skins/*/joints/*", Index("nodes")),
    ("animations/*", Required(&["channels", "samplers"])),
    ("animations/*/channels/*", Required(&["sampler", "target"])),
    ("animations/*/channels/*/sampler", Sibling("samplers")),
    ("animations/*/channels/*/target", Required(&["path"])),
    ("animations/*/channels/*/target/node", Index("nodes")),
    ("animations/*/samplers/*", Required(&["input", "output"])),
    ("animations/*/samplers/*/input", Index("accessors")),
    ("animations/*/samplers/*/output", Index("accessors")),
    ("animations/*/samplers/*/interpolation", Word(&["LINEAR", "STEP", "CUBICSPLINE"])),
    (
        "meshes/*/primitives/*/extensions/KHR_materials_variants/mappings/*",
        Required(&["material", "variants"]),
    ),
    ("extensions/KHR_materials_variants", Required(&["variants"])),
    ("extensions/KHR_materials_variants/variants/*", Required(&["name"])),
    ("extensions/KHR_materials_variants/variants/*/name", Text),
    ("extensions/KHR_lights_punctual", Required(&["lights"])),
    ("extensions/KHR_lights_punctual/lights/*", Required(&["type"])),
    ("extensions/KHR_lights_punctual/lights/*/type", Word(&["point", "spot", "directional"])),
    ("extensions/KHR_lights_punctual/lights/*/intensity", Number(0.0, INFINITY)),
    ("extensions/KHR_lights_punctual/lights/*/range", Number(f64::MIN_POSITIVE, INFINITY)),
];

/// Members, of materials or of their extensions, that are references to textures.
const TEXTURE_SUFFIX: &str = "Texture";

/// Breaches of a rule that are listed one by one; beyond that they are counted.
const MOST_APART: usize = 16;

/// Lists every breach.
pub(super) fn list(root: &Value, warnings: &mut Warnings) {
    for (pattern, rule) in RULES {
        let parts: Vec<&str> = pattern.split('/').filter(|part| !part.is_empty()).collect();
        let mut walk = Walk { root, warnings, trail: vec![root], pointer: String::new(), n_listed: 0 };
        walk.visit(root, &parts, rule);
    }
    let mut walk = Walk { root, warnings, trail: vec![root], pointer: String::new(), n_listed: 0 };
    if let Some(materials) = root.get("materials") {
        walk.down("materials", materials, |walk| walk.textures(materials, 0));
    }
}

struct Walk<'w, 'v> {
    root: &'v Value,
    warnings: &'w mut Warnings,
    /// From the document to the value that is looked at.
    trail: Vec<&'v Value>,
    pointer: String,
    n_listed: usize,
}

impl<'v> Walk<'_, 'v> {
    fn down(&mut self, key: &str, value: &'v Value, then: impl FnOnce(&mut Self)) {
        let length = self.pointer.len();
        self.pointer.push('/');
        self.pointer.push_str(&escaped(key));
        self.trail.push(value);
        then(self);
        self.trail.pop();
        self.pointer.truncate(length);
    }

    fn visit(&mut self, value: &'v Value, parts: &[&str], rule: &Rule) {
        let Some((first, rest)) = parts.split_first() else {
            if let Err(problem) = self.check(value, rule) {
                self.n_listed += 1;
                if self.n_listed <= MOST_APART {
                    self.warnings.add_apart(WarningKind::Invalid, self.pointer.clone(), problem);
                } else {
                    self.warnings.add(WarningKind::Invalid, self.pointer.clone(), problem);
                }
            }
            return;
        };
        if *first == "*" {
            for (key, child) in children(value) {
                self.down(&key, child, |walk| walk.visit(child, rest, rule));
            }
        } else if let Some(child) = value.get(first) {
            self.down(first, child, |walk| walk.visit(child, rest, rule));
        }
    }

    /// References to textures, however deep in a material.
    fn textures(&mut self, value: &'v Value, depth: usize) {
        const DEEPEST: usize = 6;
        for (key, child) in children(value) {
            if depth < DEEPEST {
                self.down(&key, child, |walk| walk.textures(child, depth + 1));
            }
            if key.ends_with(TEXTURE_SUFFIX) {
                let (required, index) = (Required(&["index"]), Index("textures"));
                self.down(&key, child, |walk| {
                    walk.visit(child, &[], &required);
                    walk.visit(child, &["index"], &index);
                    walk.visit(child, &["texCoord"], &Whole(0));
                });
            }
        }
    }

    fn check(&self, value: &Value, rule: &Rule) -> Result<(), String> {
        let expect = |holds: bool, what: &dyn Fn() -> String| if holds { Ok(()) } else { Err(what()) };
        match rule {
            Index(list) => {
                let list = list.split('/').try_fold(self.root, |at, key| at.get(key));
                in_list(value, list)
            }
            Sibling(list) => {
                // Of the object that holds the list that holds the object that this is in.
                let holder = self.trail.len().checked_sub(4).and_then(|at| self.trail.get(at));
                in_list(value, holder.and_then(|holder| holder.get(list)))
            }
            Required(members) => {
                if !value.is_object() {
                    return Err("an object is expected here".to_owned());
                }
                let missing: Vec<&str> = members.iter().copied().filter(|m| value.get(m).is_none()).collect();
                expect(missing.is_empty(), &|| format!("{} missing here", missing.join(", ")))
            }
            OneOf(numbers) => expect(value.as_u64().is_some_and(|n| numbers.contains(&n)), &|| {
                format!("one of {numbers:?} is expected here")
            }),
            Word(words) => expect(value.as_str().is_some_and(|w| words.contains(&w)), &|| {
                format!("one of {} is expected here", words.join(", "))
            }),
            Number(least, most) => {
                expect(value.as_f64().is_some_and(|x| (*least..=*most).contains(&x)), &|| match most {
                    most if most.is_finite() => {
                        format!("a number between {least} and {most} is expected here")
                    }
                    _ if *least > 0.0 => "a number above 0 is expected here".to_owned(),
                    _ => format!("a number of at least {least} is expected here"),
                })
            }
            Whole(least) => {
                let whole = value.as_f64().is_some_and(|x| x.fract() == 0.0 && x >= *least as f64);
                expect(whole, &|| format!("a whole number, at least {least}, is expected here"))
            }
            Text => expect(value.is_string(), &|| "a string is expected here".to_owned()),
            Flag => expect(value.is_boolean(), &|| "true or false is expected here".to_owned()),
            Numbers(n) => {
                let numbers =
                    value.as_array().is_some_and(|a| a.len() == *n && a.iter().all(Value::is_number));
                expect(numbers, &|| format!("{n} numbers are expected here"))
            }
        }
    }
}

fn in_list(value: &Value, list: Option<&Value>) -> Result<(), String> {
    let len = list.and_then(Value::as_array).map_or(0, Vec::len);
    match value.as_f64() {
        Some(index) if index.fract() == 0.0 && index >= 0.0 => {
            if index < len as f64 {
                Ok(())
            } else {
                Err(format!("an index of what does not exist, of {len}"))
            }
        }
        _ => Err("an index is expected here".to_owned()),
    }
}

/// Items by their number, or members by their name.
fn children(value: &Value) -> Box<dyn Iterator<Item = (String, &Value)> + '_> {
    match value {
        Value::Array(items) => Box::new(items.iter().enumerate().map(|(i, v)| (i.to_string(), v))),
        Value::Object(members) => Box::new(members.iter().map(|(k, v)| (k.clone(), v))),
        _ => Box::new(std::iter::empty()),
    }
}
