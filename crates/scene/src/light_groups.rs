//! Groups of lights, whose parts of an image are kept apart.

use std::{collections::HashMap, sync::Arc};

use crate::Scene;

/// Groups of a scene at most: each takes a film of its own. What comes after them shares the last.
pub const MAX_LIGHT_GROUPS: usize = 16;
/// The group of the lights that are one too many.
const REST: &str = "rest";
/// The environment's group, where nothing else is said.
const ENVIRONMENT: &str = "environment";
/// Characters of a group's name at most: names of layers in files are bounded too.
const MAX_NAME: usize = 64;

/// Which lights belong together: a number for each light of a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightGroups {
    /// Of each group, at least one, at most [`MAX_LIGHT_GROUPS`]; all different.
    pub names: Vec<Arc<str>>,
    /// Of each of [`Scene::instances`]; 0 where it does not emit.
    pub instances: Vec<u8>,
    /// Of each of [`Scene::lights`].
    pub lights: Vec<u8>,
    /// The environment's.
    pub environment: u8,
}

/// A group that is made of lights by their names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightGroupRule {
    /// Its name.
    pub group: String,
    /// Names of lights, or of groups as they were; a `*` stands for any text.
    pub lights: Vec<String>,
}

impl Scene {
    /// The groups of its lights: what an instance, a light or the environment is said to belong to;
    /// else a group for each name of a mesh, material or light, in the order in which they come.
    ///
    /// # Panics
    ///
    /// Where an index is out of range: call [`Scene::validate`] first.
    pub fn light_groups(&self) -> LightGroups {
        self.light_groups_under(self.environment.is_some())
    }

    /// As [`Scene::light_groups`], where there is an environment or none, whatever the scene has.
    ///
    /// # Panics
    ///
    /// As [`Scene::light_groups`].
    pub fn light_groups_under(&self, environment: bool) -> LightGroups {
        let mut groups = Grouping::default();
        let instances = (0..self.instances.len())
            .map(|i| self.emitter_name(i).map_or(0, |name| groups.of(&name)))
            .collect();
        let lights = (0..self.lights.len()).map(|i| groups.of(&self.light_name(i))).collect();
        let environment = if environment { groups.of(&self.environment_name()) } else { 0 };
        let mut names = groups.names;
        if names.is_empty() {
            names.push(REST.into());
        }
        LightGroups { names, instances, lights, environment }
    }

    /// Puts lights into groups by their names; the first rule that a light is in counts, and others
    /// stay as they are. Returns the names that no light has.
    ///
    /// # Panics
    ///
    /// Where an index is out of range: call [`Scene::validate`] first.
    pub fn group_lights(&mut self, rules: &[LightGroupRule]) -> Vec<String> {
        let mut unused: Vec<(&str, bool)> =
            rules.iter().flat_map(|rule| &rule.lights).map(|name| (name.as_str(), true)).collect();
        let mut group = |name: &str| {
            unused.iter_mut().filter(|(pattern, _)| matches(pattern, name)).for_each(|(_, u)| *u = false);
            let of = |rule: &&LightGroupRule| rule.lights.iter().any(|pattern| matches(pattern, name));
            rules.iter().find(of).map(|rule| Arc::from(rule.group.as_str()))
        };
        for i in 0..self.instances.len() {
            if let Some(group) = self.emitter_name(i).and_then(|name| group(&name)) {
                self.instances[i].light_group = Some(group);
            }
        }
        for i in 0..self.lights.len() {
            if let Some(group) = group(&self.light_name(i)) {
                self.lights[i].group = Some(group);
            }
        }
        if self.environment.is_some()
            && let Some(group) = group(&self.environment_name())
        {
            self.environment_group = Some(group);
        }
        unused.into_iter().filter(|(_, unused)| *unused).map(|(name, _)| name.to_owned()).collect()
    }

    /// What an instance that emits is called; none where it does not emit.
    fn emitter_name(&self, instance: usize) -> Option<Arc<str>> {
        let instance = &self.instances[instance];
        let mesh = &self.meshes[instance.mesh as usize];
        let material = &self.materials[mesh.material as usize];
        if !material.is_emissive() {
            return None;
        }
        let named = [&mesh.name, &material.name].into_iter().find(|name| !name.is_empty());
        Some(instance.light_group.clone().unwrap_or_else(|| match named {
            Some(name) => Arc::from(tidy(name)),
            None => format!("material {}", mesh.material).into(),
        }))
    }

    fn light_name(&self, index: usize) -> Arc<str> {
        let light = &self.lights[index];
        light.group.clone().unwrap_or_else(|| match tidy(&light.name) {
            name if name.is_empty() => format!("light {index}").into(),
            name => name.into(),
        })
    }

    fn environment_name(&self) -> Arc<str> {
        self.environment_group.clone().unwrap_or_else(|| ENVIRONMENT.into())
    }
}

#[derive(Default)]
struct Grouping {
    names: Vec<Arc<str>>,
    of: HashMap<Arc<str>, u8>,
}

impl Grouping {
    fn of(&mut self, name: &str) -> u8 {
        let name: Arc<str> = tidy(name).into();
        if let Some(&group) = self.of.get(&name) {
            return group;
        }
        let place = self.names.len();
        if place == MAX_LIGHT_GROUPS {
            self.names[place - 1] = REST.into();
            return place as u8 - 1;
        }
        self.names.push(Arc::clone(&name));
        self.of.insert(name, place as u8);
        place as u8
    }
}

/// A name as layers of files can have it: dots would cut it into layers of layers (Blender does the same).
fn tidy(name: &str) -> String {
    let clean = |c: char| if c == '.' || c.is_control() { '_' } else { c };
    name.trim().chars().take(MAX_NAME).map(clean).collect()
}

/// Whether a name is the pattern, where each `*` stands for any text.
fn matches(pattern: &str, name: &str) -> bool {
    let tidied = tidy(pattern);
    let mut parts = tidied.split('*');
    let first = parts.next().unwrap_or_default();
    let name = tidy(name);
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let Some(last) = parts.next_back() else { return rest.is_empty() };
    for part in parts {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use glam::{Mat3, Vec3};

    use super::*;
    use crate::{Environment, Instance, Light, LightKind, Material, Mesh, Surface};

    fn light(name: &str) -> Light {
        let kind = LightKind::Point { position: Vec3::ZERO, intensity: Vec3::ONE };
        Light { name: name.to_owned(), kind, group: None }
    }

    /// A wall, two lamps of one mesh, two lights, and a sky.
    fn scene() -> Scene {
        let surface = Surface::Diffuse { reflectance: Vec3::splat(0.5).into() };
        let dark = Material::new(surface);
        let mut scene = Scene {
            meshes: vec![
                Mesh { name: "wall".into(), ..Mesh::default() },
                Mesh { name: "lamp".into(), material: 1, ..Mesh::default() },
            ],
            materials: vec![dark.clone(), dark.emitting(Vec3::ONE)],
            lights: vec![light("Spot.001"), light("")],
            ..Scene::default()
        };
        scene.instances = [0, 1, 1].map(|mesh| Instance { mesh, ..Instance::default() }).into();
        scene.environment =
            Some(Environment { radiance: Vec3::ONE, image: None, world_from_environment: Mat3::IDENTITY });
        scene
    }

    fn names(scene: &Scene) -> Vec<String> {
        scene.light_groups().names.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn each_name_is_a_group() {
        let mut scene = scene();
        assert_eq!(names(&scene), ["lamp", "Spot_001", "light 1", "environment"]);
        let groups = scene.light_groups();
        assert_eq!((&groups.instances[..], &groups.lights[..]), (&[0, 0, 0][..], &[1, 2][..]));
        assert_eq!(groups.environment, 3);
        scene.instances[2].light_group = Some("desk".into());
        assert_eq!(scene.light_groups().instances, [0, 0, 1]);
        assert_eq!(Scene::default().light_groups().names.len(), 1);
    }

    #[test]
    fn rules_put_lights_together() {
        let mut scene = scene();
        let rule = |group: &str, lights: &[&str]| LightGroupRule {
            group: group.into(),
            lights: lights.iter().map(ToString::to_string).collect(),
        };
        let unused = scene.group_lights(&[
            rule("key", &["Spot.*", "environment"]),
            rule("fill", &["l*p", "light 1", "Spot*", "moon"]),
        ]);
        assert_eq!(unused, ["moon"]);
        assert_eq!(names(&scene), ["fill", "key"]);
        assert_eq!(scene.light_groups().lights, [1, 0]);
    }

    #[test]
    fn what_is_too_much_shares_the_last_group() {
        let lights = (0..40).map(|i| light(&format!("{i}"))).collect();
        let scene = Scene { lights, ..Scene::default() };
        let groups = scene.light_groups();
        assert_eq!(groups.names.len(), MAX_LIGHT_GROUPS);
        assert_eq!((&*groups.names[14], &*groups.names[15]), ("14", REST));
        assert_eq!((groups.lights[14], groups.lights[15], groups.lights[39]), (14, 15, 15));
    }

    #[test]
    fn stars_stand_for_any_text() {
        for (pattern, name, expected) in [
            ("a", "a", true),
            ("a", "ab", false),
            ("a*", "ab", true),
            ("*", "", true),
            ("a*a", "a", false),
            ("a*b*c", "a1b2c", true),
            ("a*b*c", "acb", false),
        ] {
            assert_eq!(matches(pattern, name), expected, "{pattern} {name}");
        }
    }
}
