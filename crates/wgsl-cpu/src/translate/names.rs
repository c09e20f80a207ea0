//! Rust names for WGSL's.

use std::collections::{HashMap, HashSet};

use naga::{Constant, Function, GlobalVariable, Handle, Module, Type};

/// Rust's keywords, WGSL names that are not also WGSL keywords included.
const KEYWORDS: &[&str] = &[
    "Self", "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "crate", "do",
    "dyn", "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop",
    "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "return", "self", "static",
    "struct", "super", "trait", "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual",
    "where", "while", "yield",
];

/// What the emitted source itself names, and what a `let` would take for a pattern.
const TAKEN: &[&str] = &[
    "BINDINGS",
    "Err",
    "Globals",
    "Mat",
    "None",
    "Ok",
    "Option",
    "Private",
    "Some",
    "Vec2",
    "Vec3",
    "Vec4",
    "WORKGROUP_OVERRIDE",
    "WORKGROUP_SIZE",
    "bool",
    "entry",
    "f32",
    "globals",
    "i32",
    "private",
    "rt",
    "u32",
    "usize",
    "wgsl_cpu",
];

/// The module's Rust names. WGSL has one name space for all that is declared at module scope.
pub(super) struct Names {
    types: HashMap<Handle<Type>, String>,
    functions: HashMap<Handle<Function>, String>,
    constants: HashMap<Handle<Constant>, String>,
    globals: HashMap<Handle<GlobalVariable>, String>,
    entry: String,
    taken: Scope,
}

impl Names {
    pub(super) fn new(module: &Module) -> Self {
        let mut taken = Scope::default();
        let mut unique = |name: &Option<String>| taken.unique(name.as_deref().unwrap_or("unnamed"));
        // A type's name is what programs see of it: those first.
        Self {
            types: module
                .types
                .iter()
                .filter(|(_, t)| t.name.is_some())
                .map(|(ty, t)| (ty, unique(&t.name)))
                .collect(),
            functions: module.functions.iter().map(|(f, function)| (f, unique(&function.name))).collect(),
            constants: module.constants.iter().map(|(c, constant)| (c, unique(&constant.name))).collect(),
            globals: module.global_variables.iter().map(|(g, global)| (g, unique(&global.name))).collect(),
            entry: module
                .entry_points
                .first()
                .map_or(String::new(), |entry| unique(&Some(entry.name.clone()))),
            taken,
        }
    }

    pub(super) fn ty(&self, ty: Handle<Type>) -> &str {
        &self.types[&ty]
    }

    pub(super) fn function(&self, function: Handle<Function>) -> &str {
        &self.functions[&function]
    }

    pub(super) fn constant(&self, constant: Handle<Constant>) -> &str {
        &self.constants[&constant]
    }

    pub(super) fn global(&self, global: Handle<GlobalVariable>) -> &str {
        &self.globals[&global]
    }

    /// The entry point's own function, which `entry` calls.
    pub(super) fn entry(&self) -> &str {
        &self.entry
    }

    /// The names that a function's own may not shadow.
    pub(super) fn scope(&self) -> Scope {
        self.taken.clone()
    }
}

/// Names in use.
#[derive(Clone, Default)]
pub(super) struct Scope {
    used: HashSet<String>,
}

impl Scope {
    /// `name`, or the like where it is in use already.
    pub(super) fn unique(&mut self, name: &str) -> String {
        let name = identifier(name);
        let free =
            |candidate: &String| !TAKEN.contains(&candidate.as_str()) && !self.used.contains(candidate);
        let chosen = if free(&name) {
            name
        } else if free(&format!("{name}_")) {
            format!("{name}_")
        } else {
            (1..).map(|n| format!("{name}_{n}")).find(free).unwrap_or_default()
        };
        self.used.insert(chosen.clone());
        chosen
    }
}

/// `name` as a Rust identifier: that of a struct's member.
pub(super) fn identifier(name: &str) -> String {
    if KEYWORDS.contains(&name) { format!("{name}_") } else { name.to_owned() }
}
