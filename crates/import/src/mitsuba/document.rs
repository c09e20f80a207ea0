//! The XML file and those that it includes, as objects with properties: names substituted, spelled
//! as releases since 2 spell them (`toWorld` is `to_world`), references by id.

use std::{cell::Cell, collections::HashMap};

use glam::{DMat4, Mat4};
use roxmltree::{Node, ParsingOptions};

use super::{transform, value, value::Value};
use crate::{
    ImportError, Place,
    files::{SceneFolder, shortened},
    spectrum::{Spectrum, blackbody},
    warning::{WarningKind, Warnings},
};

/// How deep elements may lie in each other, and files in each other.
const MAX_DEPTH: usize = 48;
const MAX_INCLUDE_DEPTH: usize = 15;
/// A file may be included again and again, and include others that are: this many in all.
const MAX_INCLUDES: usize = 4096;
/// Elements of all files together.
const MAX_ELEMENTS: usize = 1 << 24;

pub(super) const BLACK_BODY: &str =
    "black bodies have their colour, and the luminance of white of radiance 1";

/// What kinds of objects there are, by their tags; `luminaire` and `camera` are of release 0.2.
const CLASSES: [(&str, Class); 14] = [
    ("scene", Class::Scene),
    ("shape", Class::Shape),
    ("bsdf", Class::Bsdf),
    ("texture", Class::Texture),
    ("emitter", Class::Emitter),
    ("luminaire", Class::Emitter),
    ("sensor", Class::Sensor),
    ("camera", Class::Sensor),
    ("film", Class::Film),
    ("rfilter", Class::Filter),
    ("integrator", Class::Integrator),
    ("medium", Class::Medium),
    ("sampler", Class::Other),
    ("subsurface", Class::Medium),
];

/// Objects that only others have use for.
const OTHER_CLASSES: [&str; 3] = ["phase", "volume", "random"];

/// A kind of object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    Scene,
    Shape,
    Bsdf,
    Texture,
    Emitter,
    Sensor,
    Film,
    Filter,
    Integrator,
    Medium,
    Other,
}

/// An object: an instance of a plugin.
pub(super) struct Object {
    pub class: Class,
    /// The plugin's name.
    pub plugin: String,
    pub id: String,
    pub place: Place,
    pub properties: Vec<Property>,
    pub children: Vec<Child>,
    /// Whether something was made of it.
    pub visited: Cell<bool>,
}

/// A named value.
pub(super) struct Property {
    pub name: String,
    pub value: Value,
    /// Whether it was asked for.
    pub used: Cell<bool>,
}

/// An object in another: its name there, or empty.
pub(super) struct Child {
    pub name: String,
    pub target: Target,
}

/// Which object.
pub(super) enum Target {
    /// An index into [`Document::objects`].
    Object(usize),
    /// An id, which may be given later in the file.
    Reference(String),
}

/// All objects of a scene; the first is the scene itself.
pub(super) struct Document {
    pub objects: Vec<Object>,
    /// Whether it was written for a release before 2, which have other defaults.
    pub is_old: bool,
    ids: HashMap<String, usize>,
    aliases: HashMap<String, String>,
}

impl Document {
    /// Reads a scene's text and what it includes from its folder.
    pub fn read(
        bytes: &[u8],
        place: &Place,
        folder: &SceneFolder,
        warnings: &mut Warnings,
    ) -> Result<Self, ImportError> {
        let mut reader = Reader {
            document: Self {
                objects: Vec::new(),
                is_old: false,
                ids: HashMap::new(),
                aliases: HashMap::new(),
            },
            defaults: HashMap::new(),
            folder,
            warnings,
            n_includes: 0,
            n_elements: 0,
        };
        reader.file(bytes, place, None, 0)?;
        Ok(reader.document)
    }

    /// The objects in another with their names, but for references that lead nowhere.
    pub fn children_of<'d>(&'d self, object: &'d Object) -> impl Iterator<Item = (&'d str, &'d Object)> {
        object.children.iter().filter_map(|child| {
            let index = match &child.target {
                Target::Object(index) => Some(*index),
                Target::Reference(id) => self.by_id(id),
            };
            Some((child.name.as_str(), &self.objects[index?]))
        })
    }

    /// The object of an id; none where there is none.
    pub fn by_id(&self, id: &str) -> Option<usize> {
        let id = self.aliases.get(id).map_or(id, String::as_str);
        self.ids.get(id).copied()
    }
}

impl Object {
    /// Whether it is a texture of which nothing was made.
    pub fn is_unused_texture(&self) -> bool {
        self.class == Class::Texture && !self.visited.get()
    }
}

/// The lines of a file, for places.
struct File<'a> {
    place: &'a Place,
    /// Where each line begins.
    lines: Vec<usize>,
}

impl File<'_> {
    fn place(&self, node: Node) -> Place {
        let line = self.lines.partition_point(|&start| start <= node.range().start);
        Place::new(&self.place.file, line.to_string())
    }
}

struct Reader<'a> {
    document: Document,
    /// Values of `$name`.
    defaults: HashMap<String, String>,
    folder: &'a SceneFolder,
    warnings: &'a mut Warnings,
    n_includes: usize,
    n_elements: usize,
}

impl Reader<'_> {
    /// A file's objects, as children of `parent`, or as the scene.
    fn file(
        &mut self,
        bytes: &[u8],
        place: &Place,
        parent: Option<usize>,
        depth: usize,
    ) -> Result<(), ImportError> {
        let malformed = |place, problem: String| ImportError::Malformed { place, problem };
        let text = String::from_utf8_lossy(bytes);
        let text = text.trim_start_matches('\u{feff}');
        let options = ParsingOptions { nodes_limit: 2 * MAX_ELEMENTS as u32, ..ParsingOptions::default() };
        let xml = roxmltree::Document::parse_with_options(text, options).map_err(|error| {
            let place = Place::new(&place.file, error.pos().row.to_string());
            // It quotes the file, line breaks and all.
            let why = shortened(&error.to_string());
            malformed(place, format!("it is not XML that is read ({why})"))
        })?;
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        let file = File { place, lines };
        let root = xml.root_element();
        match parent {
            // An included file's scene is no object: what is in it belongs to the including one.
            Some(parent) if root.tag_name().name() == "scene" => self.contents(&file, root, parent, depth),
            Some(parent) => self.element(&file, root, parent, depth),
            None if root.tag_name().name() == "scene" => {
                let version = root.attribute("version").unwrap_or("3.0.0");
                self.document.is_old = version.trim_start().starts_with('0');
                self.object(&file, root, Class::Scene, 0, depth).map(drop)
            }
            None => {
                let problem =
                    format!("it is no scene of Mitsuba: it begins with <{}>", root.tag_name().name());
                Err(malformed(file.place(root), shortened(&problem)))
            }
        }
    }

    /// An object with what is in it; its index.
    fn object(
        &mut self,
        file: &File,
        node: Node,
        class: Class,
        level: usize,
        depth: usize,
    ) -> Result<usize, ImportError> {
        let place = file.place(node);
        if level > MAX_DEPTH {
            return Err(ImportError::TooBig {
                place,
                what: "elements are nested too deep".into(),
                limit: MAX_DEPTH as u64,
            });
        }
        let index = self.document.objects.len();
        let plugin = self.attribute(file, node, "type")?.unwrap_or_default();
        let id = self.attribute(file, node, "id")?.unwrap_or_default();
        if !id.is_empty() && self.document.ids.insert(id.clone(), index).is_some() {
            let problem = format!("the id {:?} is given twice", shortened(&id));
            return Err(ImportError::Malformed { place, problem });
        }
        let (properties, children) = (Vec::new(), Vec::new());
        let visited = Cell::new(false);
        self.document.objects.push(Object { class, plugin, id, place, properties, children, visited });
        for child in node.children().filter(Node::is_element) {
            self.element_at(file, child, index, level + 1, depth)?;
        }
        Ok(index)
    }

    fn contents(&mut self, file: &File, node: Node, parent: usize, depth: usize) -> Result<(), ImportError> {
        node.children()
            .filter(Node::is_element)
            .try_for_each(|child| self.element(file, child, parent, depth))
    }

    fn element(&mut self, file: &File, node: Node, parent: usize, depth: usize) -> Result<(), ImportError> {
        self.element_at(file, node, parent, 1, depth)
    }

    /// What stands in an object: another one, a property, a reference, a file.
    fn element_at(
        &mut self,
        file: &File,
        node: Node,
        parent: usize,
        level: usize,
        depth: usize,
    ) -> Result<(), ImportError> {
        self.n_elements += 1;
        if self.n_elements > MAX_ELEMENTS {
            let (place, what) = (file.place(node), "there are too many elements".to_owned());
            return Err(ImportError::TooBig { place, what, limit: MAX_ELEMENTS as u64 });
        }
        let tag = node.tag_name().name();
        let class = CLASSES.iter().find(|(name, _)| *name == tag).map(|(_, class)| *class);
        let class = class.or_else(|| OTHER_CLASSES.contains(&tag).then_some(Class::Other));
        if let Some(class) = class {
            let name = self.name(file, node)?;
            let object = self.object(file, node, class, level, depth)?;
            self.document.objects[parent].children.push(Child { name, target: Target::Object(object) });
            return Ok(());
        }
        match tag {
            "default" => {
                let name = self.required(file, node, "name")?;
                let value = self.required(file, node, "value")?;
                self.defaults.entry(name).or_insert(value);
            }
            "alias" => {
                let id = self.required(file, node, "id")?;
                let name = self.required(file, node, "as")?;
                self.document.aliases.insert(name, id);
            }
            "ref" => {
                let name = self.name(file, node)?;
                let id = self.required(file, node, "id")?;
                self.document.objects[parent].children.push(Child { name, target: Target::Reference(id) });
            }
            "include" => self.include(file, node, parent, depth)?,
            "path" => {
                let message = "search paths are not used: files are looked for in the scene's folder";
                self.warnings.add(WarningKind::Unused, file.place(node).short(), message);
            }
            _ => {
                if let Some(property) = self.property(file, node)? {
                    self.document.objects[parent].properties.push(property);
                }
            }
        }
        Ok(())
    }

    fn include(&mut self, file: &File, node: Node, parent: usize, depth: usize) -> Result<(), ImportError> {
        let place = file.place(node);
        self.n_includes += 1;
        if depth >= MAX_INCLUDE_DEPTH || self.n_includes > MAX_INCLUDES {
            let what = "files include each other without end, or too many are included".to_owned();
            return Err(ImportError::TooBig { place, what, limit: MAX_INCLUDE_DEPTH as u64 });
        }
        let name = self.required(file, node, "filename")?.replace('\\', "/");
        let path = self.folder.find(&name, &place)?;
        let bytes = self.folder.read_text(&name, &place)?;
        self.file(&bytes, &Place::new(&path, ""), Some(parent), depth + 1)
    }

    /// A property; none where it is of a kind that is listed and not used.
    fn property(&mut self, file: &File, node: Node) -> Result<Option<Property>, ImportError> {
        let tag = node.tag_name().name();
        let name = self.name(file, node)?;
        let value = match tag {
            "transform" => Value::Transform(self.transform(file, node)?),
            "animation" => {
                let message = "movement is not rendered: its first transform is used";
                self.warnings.add(WarningKind::Animation, file.place(node).short(), message);
                let first = node.children().find(|child| child.tag_name().name() == "transform");
                Value::Transform(first.map_or(Ok(Mat4::IDENTITY), |first| self.transform(file, first))?)
            }
            "blackbody" => self.blackbody(file, node)?,
            "spectrum" if node.has_attribute("type") => self.spectrum_plugin(file, node)?,
            "spectrum" if node.has_attribute("filename") => self.spectrum_file(file, node)?,
            _ => {
                let attributes = self.attributes(file, node)?;
                let attribute = |name: &str| attributes.get(name).map(String::as_str);
                match value::parse(tag, attribute) {
                    Some(value) => value,
                    None => {
                        let problem =
                            format!("<{}> is not known or has no value that is read", shortened(tag));
                        return Err(ImportError::Malformed { place: file.place(node), problem });
                    }
                }
            }
        };
        Ok(Some(Property { name, value, used: Cell::new(false) }))
    }

    fn blackbody(&mut self, file: &File, node: Node) -> Result<Value, ImportError> {
        let kelvin = self.required(file, node, "temperature")?;
        let kelvin = value::number(kelvin.trim().trim_end_matches(['K', 'k'])).filter(|t| *t > 0.0);
        let problem = || "a temperature above 0 is expected".to_owned();
        let kelvin =
            kelvin.ok_or_else(|| ImportError::Malformed { place: file.place(node), problem: problem() })?;
        let scale = self.attribute(file, node, "scale")?.as_deref().and_then(value::number).unwrap_or(1.0);
        self.warnings.add(WarningKind::Approximation, file.place(node).short(), BLACK_BODY);
        Ok(Value::Rgb(blackbody(f64::from(kelvin)) * scale))
    }

    /// A spectrum as release 3 writes it: a plugin with properties.
    fn spectrum_plugin(&mut self, file: &File, node: Node) -> Result<Value, ImportError> {
        let place = file.place(node);
        let plugin = self.required(file, node, "type")?;
        let mut properties = HashMap::new();
        for child in node.children().filter(Node::is_element) {
            if let Some(property) = self.property(file, child)? {
                properties.insert(property.name, property.value);
            }
        }
        let value = value::spectrum_plugin(&plugin, &properties).ok_or_else(|| {
            let problem = format!("a spectrum of type {:?} has no value that is read", shortened(&plugin));
            ImportError::Malformed { place: place.clone(), problem }
        })?;
        if plugin == "blackbody" {
            self.warnings.add(WarningKind::Approximation, place.short(), BLACK_BODY);
        }
        Ok(value)
    }

    fn spectrum_file(&mut self, file: &File, node: Node) -> Result<Value, ImportError> {
        let place = file.place(node);
        let name = self.required(file, node, "filename")?.replace('\\', "/");
        let bytes = self.folder.read_text(&name, &place)?;
        let spectrum = Spectrum::parse(&String::from_utf8_lossy(&bytes));
        spectrum.map(Value::Spectrum).ok_or_else(|| ImportError::Malformed {
            place,
            problem: format!("\"{}\" does not hold pairs of a wavelength and a value", shortened(&name)),
        })
    }

    fn transform(&mut self, file: &File, node: Node) -> Result<Mat4, ImportError> {
        let mut total = DMat4::IDENTITY;
        for child in node.children().filter(Node::is_element) {
            let attributes = self.attributes(file, child)?;
            let step = transform::step(child, |name| attributes.get(name).map(String::as_str));
            let malformed = |problem| ImportError::Malformed { place: file.place(child), problem };
            total = step.map_err(malformed)? * total;
        }
        let total = total.as_mat4();
        if total.is_finite() {
            return Ok(total);
        }
        Err(ImportError::Malformed { place: file.place(node), problem: "a transform is not finite".into() })
    }

    /// The name of a property or child, as releases since 2 spell it.
    fn name(&self, file: &File, node: Node) -> Result<String, ImportError> {
        Ok(snake_case(&self.attribute(file, node, "name")?.unwrap_or_default()))
    }

    fn required(&self, file: &File, node: Node, name: &str) -> Result<String, ImportError> {
        self.attribute(file, node, name)?.ok_or_else(|| {
            let problem = format!("<{}> needs the attribute \"{name}\"", node.tag_name().name());
            ImportError::Malformed { place: file.place(node), problem }
        })
    }

    fn attributes(&self, file: &File, node: Node) -> Result<HashMap<String, String>, ImportError> {
        let pair = |name: &str| Ok(self.attribute(file, node, name)?.map(|value| (name.to_owned(), value)));
        node.attributes().filter_map(|attribute| pair(attribute.name()).transpose()).collect()
    }

    /// An attribute with `$name` replaced by its value.
    fn attribute(&self, file: &File, node: Node, name: &str) -> Result<Option<String>, ImportError> {
        let Some(text) = node.attribute(name) else { return Ok(None) };
        if !text.contains('$') {
            return Ok(Some(text.to_owned()));
        }
        let mut out = String::new();
        let mut rest = text;
        while let Some(at) = rest.find('$') {
            out.push_str(&rest[..at]);
            let after = rest[at + 1..].trim_start_matches('{');
            let length = after.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(after.len());
            let (parameter, tail) = after.split_at(length);
            let value = self.defaults.get(parameter).ok_or_else(|| ImportError::Malformed {
                place: file.place(node),
                problem: format!("there is no <default> for \"${}\"", shortened(parameter)),
            })?;
            out.push_str(value);
            rest = if after.len() < rest.len() - at - 1 { tail.trim_start_matches('}') } else { tail };
        }
        out.push_str(rest);
        Ok(Some(out))
    }
}

/// `toWorld` as `to_world`, `intIOR` as `int_ior`.
fn snake_case(name: &str) -> String {
    let mut out = String::with_capacity(name.len() + 4);
    let mut before = '_';
    for c in name.chars() {
        if c.is_ascii_uppercase() && before.is_ascii_lowercase() {
            out.push('_');
        }
        out.push(c.to_ascii_lowercase());
        before = c;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_spelled_as_since_release_2() {
        for (old, new) in [
            ("toWorld", "to_world"),
            ("intIOR", "int_ior"),
            ("uoffset", "uoffset"),
            ("flip_normals", "flip_normals"),
            ("sigmaT", "sigma_t"),
            ("alphaU", "alpha_u"),
        ] {
            assert_eq!(snake_case(old), new);
        }
    }
}
