//! An object as those who make something of it see it: properties by name and type.

use std::collections::HashMap;

use glam::{Mat4, Vec3};

use super::{
    document::{Child, Class, Document, Object, Property, Target},
    value::{Quantity, Value},
};
use crate::{ImportError, files::shortened};

/// An object of a document.
#[derive(Clone, Copy)]
pub(super) struct Node<'a> {
    document: &'a Document,
    /// Its index in the document.
    pub index: usize,
}

impl<'a> Node<'a> {
    /// The scene.
    pub fn root(document: &'a Document) -> Self {
        Self { document, index: 0 }
    }

    fn object(&self) -> &'a Object {
        &self.document.objects[self.index]
    }

    pub fn class(&self) -> Class {
        self.object().class
    }

    /// The plugin's name; something is made of the object.
    pub fn plugin(&self) -> &'a str {
        self.object().visited.set(true);
        &self.object().plugin
    }

    pub fn id(&self) -> &'a str {
        &self.object().id
    }

    /// For errors.
    pub fn place(&self) -> &'a crate::Place {
        &self.object().place
    }

    pub fn malformed(&self, problem: impl Into<String>) -> ImportError {
        ImportError::Malformed { place: self.place().clone(), problem: problem.into() }
    }

    /// The value of a property; it counts as used.
    pub fn value(&self, name: &str) -> Option<&'a Value> {
        let property = self.object().properties.iter().rev().find(|property| property.name == name)?;
        property.used.set(true);
        Some(&property.value)
    }

    /// All properties, by name; they count as used.
    pub fn values(&self) -> HashMap<String, Value> {
        let used = |property: &Property| {
            property.used.set(true);
            (property.name.clone(), property.value.clone())
        };
        self.object().properties.iter().map(used).collect()
    }

    pub fn has(&self, name: &str) -> bool {
        self.object().properties.iter().any(|property| property.name == name)
    }

    /// Counts properties as used that change nothing here.
    pub fn disregard(&self, names: &[&str]) {
        for name in names {
            self.value(name);
        }
    }

    /// Counts the textures in it as used that something else is said of.
    pub fn disregard_textures(&self) -> Result<(), ImportError> {
        self.all(Class::Texture)?.iter().for_each(|texture| texture.object().visited.set(true));
        Ok(())
    }

    fn typed<T>(
        &self,
        name: &str,
        what: &str,
        of: impl Fn(&'a Value) -> Option<T>,
    ) -> Result<Option<T>, ImportError> {
        let Some(value) = self.value(name) else { return Ok(None) };
        match of(value) {
            Some(value) => Ok(Some(value)),
            None => Err(self.malformed(format!("\"{name}\" has to be {what}"))),
        }
    }

    pub fn float(&self, name: &str) -> Result<Option<f32>, ImportError> {
        self.typed(name, "a number", |value| match value {
            Value::Float(x) | Value::Constant(x) => Some(*x),
            Value::Integer(i) => Some(*i as f32),
            _ => None,
        })
    }

    pub fn float_or(&self, name: &str, default: f32) -> Result<f32, ImportError> {
        Ok(self.float(name)?.unwrap_or(default))
    }

    pub fn integer(&self, name: &str) -> Result<Option<i64>, ImportError> {
        self.typed(name, "a whole number", |value| match value {
            Value::Integer(i) => Some(*i),
            _ => None,
        })
    }

    pub fn boolean_or(&self, name: &str, default: bool) -> Result<bool, ImportError> {
        let value = self.typed(name, "true or false", |value| match value {
            Value::Boolean(b) => Some(*b),
            _ => None,
        })?;
        Ok(value.unwrap_or(default))
    }

    pub fn text(&self, name: &str) -> Result<Option<&'a str>, ImportError> {
        self.typed(name, "a string", |value| match value {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        })
    }

    pub fn vector(&self, name: &str) -> Result<Option<Vec3>, ImportError> {
        self.typed(name, "a point or a vector", |value| match value {
            Value::Vector(v) => Some(*v),
            _ => None,
        })
    }

    /// A colour, not below 0.
    pub fn color(&self, name: &str, quantity: Quantity) -> Result<Option<Vec3>, ImportError> {
        let color = self.typed(name, "a colour or a spectrum", |value| value.color(quantity))?;
        match color {
            Some(color) if color.min_element() < 0.0 => Err(self.malformed(format!("\"{name}\" is below 0"))),
            // No negative zero.
            color => Ok(color.map(|color| color + Vec3::ZERO)),
        }
    }

    pub fn transform(&self, name: &str) -> Result<Option<Mat4>, ImportError> {
        self.typed(name, "a transform", |value| match value {
            Value::Transform(m) => Some(*m),
            _ => None,
        })
    }

    /// Where the object is in the world.
    pub fn to_world(self) -> Result<Mat4, ImportError> {
        Ok(self.transform("to_world")?.unwrap_or(Mat4::IDENTITY))
    }

    /// A file's name, as paths are written here.
    pub fn filename(&self) -> Result<String, ImportError> {
        let name = self.text("filename")?.ok_or_else(|| self.malformed("it names no file (\"filename\")"))?;
        Ok(name.replace('\\', "/"))
    }

    /// All objects in it with their names, references followed.
    ///
    /// # Errors
    ///
    /// Where a reference leads nowhere.
    pub fn children(&self) -> Result<Vec<(&'a str, Node<'a>)>, ImportError> {
        self.object().children.iter().map(|child| Ok((child.name.as_str(), self.follow(child)?))).collect()
    }

    fn follow(&self, child: &'a Child) -> Result<Node<'a>, ImportError> {
        let index = match &child.target {
            Target::Object(index) => *index,
            Target::Reference(id) => self.document.by_id(id).ok_or_else(|| {
                self.malformed(format!("it refers to {:?}, and nothing has this id", shortened(id)))
            })?,
        };
        Ok(Node { document: self.document, index })
    }

    /// The objects of a class in it.
    pub fn all(&self, class: Class) -> Result<Vec<Node<'a>>, ImportError> {
        Ok(self.children()?.into_iter().map(|(_, node)| node).filter(|node| node.class() == class).collect())
    }

    /// The first object of a class in it.
    pub fn first(&self, class: Class) -> Result<Option<Node<'a>>, ImportError> {
        Ok(self.all(class)?.into_iter().next())
    }

    /// The object in it that has a name.
    pub fn child(&self, name: &str) -> Result<Option<Node<'a>>, ImportError> {
        Ok(self.children()?.into_iter().find(|(known, _)| *known == name).map(|(_, node)| node))
    }
}
