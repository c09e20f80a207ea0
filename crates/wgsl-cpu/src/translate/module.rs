//! Modules as Rust.

use std::{collections::HashSet, fmt::Write as _};

use naga::{
    AddressSpace, Constant, Expression, Function, GlobalVariable, Handle, ImageClass, ImageDimension,
    Literal, Module, ScalarKind, ShaderStage, Span, StorageAccess, StructMember, Type, TypeInner,
    valid::{FunctionInfo, ModuleInfo},
};

use crate::runtime::{self, BindingKind};

use super::{
    Native, Translation,
    error::{Result, Unsupported},
    function::{Reach, entry_arguments, write_entry, write_function},
    literal,
    names::{Names, identifier},
    reach::{add_type, called_functions, used_constants},
    reflect::{self, BindingInfo, EntryInfo},
    types::{alignment, is_predeclared, is_value, rust_type},
};

/// Translates a valid module.
pub(super) fn translate(
    wgsl: &str,
    module: &Module,
    info: &ModuleInfo,
    natives: &[Native],
) -> Result<Translation> {
    if let Some((handle, _)) = module.overrides.iter().find(|(_, value)| value.init.is_none()) {
        let span = module.overrides.get_span(handle);
        return Err(Unsupported::new("a pipeline override without a default", span));
    }
    let entry = entry_info(wgsl, module)?;
    let writer = ModuleWriter::new(module, info, entry.as_ref());
    let bindings = writer.bindings()?;
    Ok(Translation {
        rust: writer.write(&bindings, entry.as_ref(), natives)?,
        entry,
        bindings,
        structs: reflect::structs(module),
        constants: reflect::constants(module),
    })
}

/// `texture_2d_array<u32>`, the one kind of texture there is.
fn is_texel_store(inner: &TypeInner) -> bool {
    matches!(
        inner,
        TypeInner::Image {
            dim: ImageDimension::D2,
            arrayed: true,
            class: ImageClass::Sampled { kind: ScalarKind::Uint, multi: false },
        }
    )
}

fn entry_info(wgsl: &str, module: &Module) -> Result<Option<EntryInfo>> {
    let at = |name: &str| find_function(wgsl, name);
    if let Some(second) = module.entry_points.get(1) {
        return Err(Unsupported::new("a second entry point", at(&second.name)));
    }
    let Some(entry) = module.entry_points.first() else { return Ok(None) };
    if entry.stage != ShaderStage::Compute {
        return Err(Unsupported::new("an entry point that is not @compute", at(&entry.name)));
    }
    let [x, y, z] = entry.workgroup_size;
    let [chosen, rows, layers] = entry.workgroup_size_overrides.unwrap_or_default();
    if (y, z) != (1, 1) || rows.is_some() || layers.is_some() {
        return Err(Unsupported::new("a workgroup of more than one dimension", at(&entry.name)));
    }
    let (workgroup_size, workgroup_override) = match chosen {
        None => (x, None),
        Some(size) => {
            let named = named_size(module, size);
            let named = named.ok_or_else(|| Unsupported::new("this size of a workgroup", at(&entry.name)));
            named.map(|(default, name)| (default, Some(name)))?
        }
    };
    Ok(Some(EntryInfo { name: entry.name.clone(), workgroup_size, workgroup_override }))
}

/// Default and name of an override that is a workgroup's size.
fn named_size(module: &Module, size: Handle<Expression>) -> Option<(u32, String)> {
    let Expression::Override(handle) = module.global_expressions[size] else { return None };
    let value = &module.overrides[handle];
    let Expression::Literal(Literal::U32(default)) = module.global_expressions[value.init?] else {
        return None;
    };
    Some((default, value.name.clone()?))
}

/// Where the source declares a function: naga does not say for entry points.
fn find_function(wgsl: &str, name: &str) -> Span {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let declared = wgsl.match_indices(name).find(|&(at, _)| {
        let (before, after) = (&wgsl[..at], &wgsl[at + name.len()..]);
        before.trim_end().ends_with("fn")
            && before.ends_with(char::is_whitespace)
            && !after.starts_with(is_name)
    });
    declared.map_or(Span::UNDEFINED, |(at, _)| Span::from(at..at + name.len()))
}

struct ModuleWriter<'a> {
    module: &'a Module,
    info: &'a ModuleInfo,
    names: Names,
    /// The functions to write, callees first.
    functions: Vec<Handle<Function>>,
    globals: Vec<Handle<GlobalVariable>>,
    has_entry: bool,
}

impl<'a> ModuleWriter<'a> {
    fn new(module: &'a Module, info: &'a ModuleInfo, entry: Option<&EntryInfo>) -> Self {
        let all_functions = module.functions.iter().map(|(handle, _)| handle);
        let all_globals = module.global_variables.iter().map(|(handle, _)| handle);
        let (functions, globals) = match entry {
            Some(_) => {
                let reached = called_functions(module, &module.entry_points[0].function);
                let uses: &FunctionInfo = info.get_entry_point(0);
                (
                    all_functions.filter(|handle| reached.contains(handle)).collect(),
                    all_globals.filter(|&handle| !uses[handle].is_empty()).collect(),
                )
            }
            None => (all_functions.collect(), all_globals.collect()),
        };
        Self { module, info, names: Names::new(module), functions, globals, has_entry: entry.is_some() }
    }

    /// The buffers, sorted by slot. Refuses variables in other address spaces.
    fn bindings(&self) -> Result<Vec<BindingInfo>> {
        let mut bindings = Vec::new();
        for &handle in &self.globals {
            let span = self.module.global_variables.get_span(handle);
            bindings.extend(self.binding(handle).map_err(|unsupported| unsupported.or_at(span))?);
        }
        bindings.sort_by_key(|binding| binding.slot);
        Ok(bindings)
    }

    fn binding(&self, handle: Handle<GlobalVariable>) -> Result<Option<BindingInfo>> {
        let global = &self.module.global_variables[handle];
        let kind = match global.space {
            AddressSpace::Private => return Ok(None),
            AddressSpace::Uniform => BindingKind::Uniform,
            AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => {
                BindingKind::StorageReadWrite
            }
            AddressSpace::Storage { .. } => BindingKind::StorageRead,
            AddressSpace::WorkGroup => return Err(Unsupported::new("workgroup memory", Span::UNDEFINED)),
            AddressSpace::Handle if is_texel_store(&self.module.types[global.ty].inner) => {
                BindingKind::Texels
            }
            AddressSpace::Handle => {
                return Err(Unsupported::new("a texture or a sampler", Span::UNDEFINED));
            }
            _ => return Err(Unsupported::new("this address space", Span::UNDEFINED)),
        };
        let Some(resource) = global.binding.filter(|resource| resource.group == 0) else {
            return Err(Unsupported::new("a binding outside group 0", Span::UNDEFINED));
        };
        let inner = &self.module.types[global.ty].inner;
        let min_bytes = match kind {
            BindingKind::Texels => runtime::TEXEL_BYTES,
            _ => inner.size(self.module.to_ctx()),
        };
        Ok(Some(BindingInfo {
            name: global.name.clone().unwrap_or_default(),
            slot: resource.binding,
            kind,
            min_bytes: u64::from(min_bytes),
            ty: reflect::type_info(self.module, global.ty),
        }))
    }

    fn write(
        &self,
        bindings: &[BindingInfo],
        entry: Option<&EntryInfo>,
        natives: &[Native],
    ) -> Result<String> {
        let mut parts = vec![
            "use ::wgsl_cpu::runtime::{self as rt, Mat, Vec2, Vec3, Vec4};\n".to_owned(),
            self.structs()?,
            self.constants()?,
        ];
        if !bindings.is_empty() {
            parts.push(binding_records(bindings));
            parts.push(self.globals(bindings)?);
        }
        parts.push(self.private()?);
        for &function in &self.functions {
            let name = self.module.functions[function].name.as_deref();
            let native = natives.iter().find(|native| name == Some(native.function));
            parts.push(write_function(self.module, self.info, &self.names, function, native)?);
        }
        if let Some(entry) = entry {
            parts.push(write_entry(self.module, self.info, &self.names)?);
            parts.push(self.entry(entry, !bindings.is_empty())?);
        }
        parts.retain(|part| !part.is_empty());
        Ok(parts.iter().map(|part| part.trim_end()).collect::<Vec<_>>().join("\n\n") + "\n")
    }

    fn written_functions(&self) -> impl Iterator<Item = &'a Function> {
        let entry = self.module.entry_points.iter().map(|entry| &entry.function);
        self.functions.iter().map(|&handle| &self.module.functions[handle]).chain(entry)
    }

    fn structs(&self) -> Result<String> {
        let (used, stored) = (self.used_types(), self.stored_types());
        let mut code = String::new();
        for (handle, ty) in self.module.types.iter() {
            let TypeInner::Struct { members, span } = &ty.inner else { continue };
            let is_declared = is_value(self.module, handle) && !is_predeclared(self.module, handle);
            if is_declared && used.contains(&handle) {
                code += &self.structure(handle, members)?;
                if stored.contains(&handle) {
                    code += &self.stored(handle, members, *span)?;
                }
            }
        }
        Ok(code)
    }

    /// The types of all values in what is written; without an entry point, all types.
    fn used_types(&self) -> HashSet<Handle<Type>> {
        if !self.has_entry {
            return self.module.types.iter().map(|(handle, _)| handle).collect();
        }
        let mut types = HashSet::new();
        let of_functions = self.written_functions().flat_map(|function| {
            let locals = function.local_variables.iter().map(|(_, local)| local.ty);
            let arguments = function.arguments.iter().map(|argument| argument.ty);
            let composed = function.expressions.iter().filter_map(|(_, expression)| match *expression {
                Expression::Compose { ty, .. } | Expression::ZeroValue(ty) => Some(ty),
                _ => None,
            });
            locals.chain(arguments).chain(function.result.as_ref().map(|result| result.ty)).chain(composed)
        });
        let of_globals = self.globals.iter().map(|&global| self.module.global_variables[global].ty);
        let of_constants =
            self.used_constants().into_iter().map(|constant| self.module.constants[constant].ty);
        of_functions
            .chain(of_globals)
            .chain(of_constants)
            .for_each(|ty| add_type(self.module, ty, &mut types));
        types
    }

    /// The types that buffers hold.
    fn stored_types(&self) -> HashSet<Handle<Type>> {
        let mut types = HashSet::new();
        for &global in &self.globals {
            let global = &self.module.global_variables[global];
            if global.space != AddressSpace::Private {
                add_type(self.module, global.ty, &mut types);
            }
        }
        types
    }

    fn rust_type(&self, ty: Handle<Type>) -> Result<String> {
        rust_type(self.module, &self.names, ty)
    }

    fn structure(&self, ty: Handle<Type>, members: &[StructMember]) -> Result<String> {
        let name = self.names.ty(ty);
        let mut declarations = String::new();
        let mut zeros = String::new();
        for member in members {
            let member_name = member_name(member);
            let _ = writeln!(declarations, "    pub {member_name}: {},", self.rust_type(member.ty)?);
            let _ = writeln!(zeros, "        {member_name}: rt::zero(),");
        }
        Ok(format!(
            "#[derive(Clone, Copy, Debug, PartialEq)]\npub struct {name} {{\n{declarations}}}\n\n\
             impl rt::Zero for {name} {{\n    const ZERO: Self = Self {{\n{zeros}    }};\n}}\n\n"
        ))
    }

    /// How a struct is loaded and stored, member by member.
    fn stored(&self, ty: Handle<Type>, members: &[StructMember], span: u32) -> Result<String> {
        let (mut loads, mut stores) = (String::new(), String::new());
        let align = alignment(self.module, ty);
        for member in members {
            let (name, offset) = (member_name(member), member.offset);
            let _ = writeln!(loads, "                {name}: rt::Stored::load(bytes.add({offset})),");
            let _ = writeln!(stores, "            self.{name}.store(bytes.add({offset}));");
        }
        Ok(format!(
            "impl rt::Stored for {name} {{\n    const SIZE: usize = {span};\n    const ALIGN: usize = {align};\n    \
             #[inline(always)]\n    unsafe fn load(bytes: *const u8) -> Self {{\n        \
             // SAFETY: the members lie inside the struct, whose place is valid by contract.\n        \
             unsafe {{\n            Self {{\n{loads}            }}\n        }}\n    }}\n    \
             #[inline(always)]\n    unsafe fn store(self, bytes: *mut u8) {{\n        \
             // SAFETY: as for loading.\n        unsafe {{\n{stores}        }}\n    }}\n}}\n\n",
            name = self.names.ty(ty),
        ))
    }

    fn used_constants(&self) -> HashSet<Handle<Constant>> {
        if !self.has_entry {
            return self.module.constants.iter().map(|(handle, _)| handle).collect();
        }
        let initial = self.globals.iter().filter_map(|&global| self.module.global_variables[global].init);
        used_constants(self.module, self.written_functions(), initial)
    }

    /// Scalars and vectors as `const`; arrays, which are indexed in place, as `static`.
    fn constants(&self) -> Result<String> {
        let used = self.used_constants();
        let mut code = String::new();
        for (handle, constant) in self.module.constants.iter() {
            if constant.name.is_none() || !used.contains(&handle) {
                continue;
            }
            let is_aggregate = matches!(
                self.module.types[constant.ty].inner,
                TypeInner::Array { .. } | TypeInner::Struct { .. }
            );
            let keyword = if is_aggregate { "static" } else { "const" };
            let value = literal::constant(self.module, &self.names, constant.init)?.code;
            let (name, ty) = (self.names.constant(handle), self.rust_type(constant.ty)?);
            let _ = writeln!(code, "pub {keyword} {name}: {ty} = {value};");
        }
        Ok(code)
    }

    /// `Globals`: the buffers, and the values of uniforms.
    fn globals(&self, bindings: &[BindingInfo]) -> Result<String> {
        let (mut members, mut values) = (String::new(), String::new());
        for (at, binding) in bindings.iter().enumerate() {
            let handle = self.globals.iter().find(|&&handle| {
                self.module.global_variables[handle].binding.is_some_and(|b| b.binding == binding.slot)
            });
            let Some(&handle) = handle else { continue };
            let name = self.names.global(handle);
            if binding.kind == BindingKind::Uniform {
                let ty = self.rust_type(self.module.global_variables[handle].ty)?;
                let _ = writeln!(members, "    pub {name}: {ty},");
                let _ = writeln!(values, "                {name}: bindings[{at}].at(0).load(),");
            } else {
                let _ = writeln!(members, "    pub {name}: rt::Storage<'a>,");
                let _ = writeln!(values, "                {name}: bindings[{at}],");
            }
        }
        Ok(format!(
            "#[derive(Clone, Copy, Debug)]\npub struct Globals<'a> {{\n{members}}}\n\nimpl<'a> Globals<'a> {{\n    \
             /// # Safety\n    /// As for `NativeEntry`, as long as the result is in use.\n    \
             pub unsafe fn new(bindings: &[rt::Storage<'a>]) -> Self {{\n        \
             rt::check_bindings(BINDINGS, bindings);\n        \
             // SAFETY: the buffers are large enough for the uniforms.\n        \
             unsafe {{\n            Self {{\n{values}            }}\n        }}\n    }}\n}}\n"
        ))
    }

    /// `Private`: the variables that each invocation has of its own.
    fn private(&self) -> Result<String> {
        let (mut members, mut values) = (String::new(), String::new());
        for &handle in &self.globals {
            let global = &self.module.global_variables[handle];
            if global.space != AddressSpace::Private {
                continue;
            }
            let name = self.names.global(handle);
            let value = match global.init {
                Some(init) => literal::constant(self.module, &self.names, init)?.code,
                None => "rt::zero()".to_owned(),
            };
            let _ = writeln!(members, "    pub {name}: {},", self.rust_type(global.ty)?);
            let _ = writeln!(values, "            {name}: {value},");
        }
        if members.is_empty() {
            return Ok(String::new());
        }
        Ok(format!(
            "#[derive(Clone, Copy, Debug)]\npub struct Private {{\n{members}}}\n\nimpl Private {{\n    \
             #[inline(always)]\n    pub fn new() -> Self {{\n        Self {{\n{values}        }}\n    }}\n}}\n"
        ))
    }

    /// `entry`, the loop over the invocations.
    fn entry(&self, entry: &EntryInfo, has_globals: bool) -> Result<String> {
        let reach = Reach::new(self.module, self.info.get_entry_point(0));
        let mut arguments = Vec::new();
        arguments.extend(reach.globals.then(|| "&globals".to_owned()));
        arguments.extend(reach.private.then(|| "&mut Private::new()".to_owned()));
        arguments.extend(entry_arguments(self.module, &self.names)?);
        let globals = if has_globals {
            "    // SAFETY: this function's own contract.\n    let globals = unsafe { Globals::new(bindings) };\n"
        } else {
            ""
        };
        let records = if has_globals { "" } else { "pub const BINDINGS: &[rt::Binding] = &[];\n" };
        Ok(format!(
            "{records}pub const WORKGROUP_SIZE: u32 = {};\n\
             pub const WORKGROUP_OVERRIDE: Option<&str> = {:?};\n\n/// # Safety\n/// As for `NativeEntry`.\n\
             pub unsafe fn entry(bindings: &[rt::Storage<'_>], invocations: rt::Invocations) {{\n{globals}    \
             invocations.for_each(WORKGROUP_SIZE, |invocation| {}({}));\n}}\n",
            entry.workgroup_size,
            entry.workgroup_override,
            self.names.entry(),
            arguments.join(", "),
        ))
    }
}

/// `BINDINGS`.
fn binding_records(bindings: &[BindingInfo]) -> String {
    let mut code = String::from("pub const BINDINGS: &[rt::Binding] = &[\n");
    for BindingInfo { name, slot, kind, min_bytes, .. } in bindings {
        let _ = writeln!(
            code,
            "    rt::Binding {{ name: {name:?}, slot: {slot}, kind: rt::BindingKind::{kind:?}, min_bytes: {min_bytes} }},"
        );
    }
    code + "];\n"
}

fn member_name(member: &StructMember) -> String {
    identifier(member.name.as_deref().unwrap_or_default())
}
