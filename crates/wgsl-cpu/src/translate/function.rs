//! Functions as Rust.

use std::collections::HashMap;

use naga::{
    AddressSpace, BuiltIn, Expression, Function, Handle, LocalVariable, Module, Span, Type, TypeInner,
    valid::{FunctionInfo, ModuleInfo},
};

use super::{
    Native,
    control::Frame,
    error::{Result, Unsupported},
    expression::Text,
    literal,
    names::{Names, Scope},
    schedule::Schedule,
    types::{plain_type, rust_type},
};

/// Functions with at most this many expressions and no loop are always inlined.
const SMALL: usize = 48;

/// Writes one function.
pub(super) struct FunctionWriter<'a> {
    pub(super) module: &'a Module,
    pub(super) module_info: &'a ModuleInfo,
    pub(super) info: &'a FunctionInfo,
    pub(super) names: &'a Names,
    pub(super) function: &'a Function,
    pub(super) schedule: Schedule,
    pub(super) scope: Scope,
    /// The arguments' names.
    pub(super) arguments: Vec<Text>,
    /// The local variables' names.
    pub(super) locals: HashMap<Handle<LocalVariable>, String>,
    /// The expressions that have a name, or are written at their only use.
    pub(super) values: HashMap<Handle<Expression>, Text>,
    /// The operators that variables of naga's stand for.
    pub(super) logicals: HashMap<Handle<LocalVariable>, Text>,
    /// The loops and switches around.
    pub(super) frames: Vec<Frame>,
    pub(super) code: String,
    pub(super) indent: usize,
    pub(super) n_labels: usize,
}

/// Which module variables a function reaches, itself or through calls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    pub(super) globals: bool,
    pub(super) private: bool,
}

impl Reach {
    pub(super) fn new(module: &Module, info: &FunctionInfo) -> Self {
        let reaches = |is_private: bool| {
            module.global_variables.iter().any(|(handle, global)| {
                !info[handle].is_empty() && (global.space == AddressSpace::Private) == is_private
            })
        };
        Self { globals: reaches(false), private: reaches(true) }
    }
}

/// Writes a function of the module, or what stands for it.
pub(super) fn write_function(
    module: &Module,
    module_info: &ModuleInfo,
    names: &Names,
    handle: Handle<Function>,
    native: Option<&Native>,
) -> Result<String> {
    let function = &module.functions[handle];
    let writer = FunctionWriter::new(module, module_info, &module_info[handle], names, function);
    let name = names.function(handle);
    let written = match native {
        Some(native) => writer.write_native(native, name),
        None => writer.write("pub fn", name),
    };
    written.map_err(|e| e.or_at(module.functions.get_span(handle)))
}

/// Writes the entry point, whose arguments are those that [`entry_arguments`] passes.
pub(super) fn write_entry(module: &Module, module_info: &ModuleInfo, names: &Names) -> Result<String> {
    let function = &module.entry_points[0].function;
    let info = module_info.get_entry_point(0);
    FunctionWriter::new(module, module_info, info, names, function).write("fn", names.entry())
}

/// What is passed for the entry point's arguments: built-in values, or structs of them.
pub(super) fn entry_arguments(module: &Module, names: &Names) -> Result<Vec<String>> {
    let arguments = &module.entry_points[0].function.arguments;
    arguments
        .iter()
        .map(|argument| match (&argument.binding, &module.types[argument.ty].inner) {
            (None, TypeInner::Struct { members, .. }) => {
                let values = members.iter().map(|member| built_in(member.binding.as_ref()).map(Text::atom));
                let values = values.collect::<Result<Vec<_>>>()?;
                Ok(literal::compose(module, names, argument.ty, &values)?.code)
            }
            (binding, _) => built_in(binding.as_ref()),
        })
        .collect()
}

fn built_in(binding: Option<&naga::Binding>) -> Result<String> {
    let name = match binding {
        Some(naga::Binding::BuiltIn(BuiltIn::GlobalInvocationId)) => "global_invocation_id",
        Some(naga::Binding::BuiltIn(BuiltIn::LocalInvocationId)) => "local_invocation_id",
        Some(naga::Binding::BuiltIn(BuiltIn::LocalInvocationIndex)) => "local_invocation_index",
        Some(naga::Binding::BuiltIn(BuiltIn::WorkGroupId)) => "workgroup_id",
        Some(naga::Binding::BuiltIn(BuiltIn::NumWorkGroups)) => "num_workgroups",
        other => {
            return Err(Unsupported::new(format!("the entry point's input {other:?}"), Span::UNDEFINED));
        }
    };
    Ok(format!("invocation.{name}"))
}

impl<'a> FunctionWriter<'a> {
    fn new(
        module: &'a Module,
        module_info: &'a ModuleInfo,
        info: &'a FunctionInfo,
        names: &'a Names,
        function: &'a Function,
    ) -> Self {
        let mut scope = names.scope();
        let mut unique = |name: &Option<String>, or: &str| scope.unique(name.as_deref().unwrap_or(or));
        let arguments = function.arguments.iter().map(|a| Text::atom(unique(&a.name, "argument"))).collect();
        let locals =
            function.local_variables.iter().map(|(l, local)| (l, unique(&local.name, "test"))).collect();
        Self {
            module,
            module_info,
            info,
            names,
            function,
            schedule: Schedule::new(module, function, info),
            scope,
            arguments,
            locals,
            values: HashMap::new(),
            logicals: HashMap::new(),
            frames: Vec::new(),
            code: String::new(),
            indent: 1,
            n_labels: 0,
        }
    }

    /// The type of an expression.
    pub(super) fn inner(&self, expression: Handle<Expression>) -> &TypeInner {
        self.info[expression].ty.inner_with(&self.module.types)
    }

    /// The Rust type of an expression that is a value.
    pub(super) fn value_type(&self, expression: Handle<Expression>) -> Result<String> {
        match self.info[expression].ty.handle() {
            Some(ty) => rust_type(self.module, self.names, ty),
            None => plain_type(self.inner(expression)),
        }
    }

    fn write(mut self, keyword: &str, name: &str) -> Result<String> {
        let signature = self.signature(keyword, name)?;
        let is_unsafe = self.accesses_storage();
        if is_unsafe {
            self.line(
                "// SAFETY: `Globals::new`'s contract: the buffers hold what is accessed here, and every",
            );
            self.line("// index is kept in range.");
            self.line("unsafe {");
            self.indent += 1;
        }
        self.head_locals()?;
        let function = self.function;
        self.block(&function.body, true)?;
        if is_unsafe {
            self.indent -= 1;
            self.line("}");
        }
        Ok(format!("{}\n{signature} {{\n{}}}\n", self.inline_attribute(), self.code))
    }

    /// Passes all arguments to the macro of a function that is written by hand.
    fn write_native(self, native: &Native, name: &str) -> Result<String> {
        let signature = self.signature("pub fn", name)?;
        let reach = Reach::new(self.module, self.info);
        let own = [(reach.globals, "globals"), (reach.private, "private")];
        let passed = own.into_iter().filter_map(|(is_there, name)| is_there.then_some(name));
        let arguments = passed.chain(self.arguments.iter().map(|argument| argument.code.as_str()));
        let arguments = arguments.collect::<Vec<_>>().join(", ");
        Ok(format!("#[inline]\n{signature} {{\n    {}!({arguments})\n}}\n", native.path))
    }

    fn inline_attribute(&self) -> &'static str {
        let is_small = self.function.expressions.len() <= SMALL && !self.code.contains("loop {");
        if is_small { "#[inline(always)]" } else { "#[inline]" }
    }

    fn signature(&self, keyword: &str, name: &str) -> Result<String> {
        let reach = Reach::new(self.module, self.info);
        let mut arguments = Vec::new();
        if reach.globals {
            arguments.push("globals: &Globals<'_>".to_owned());
        }
        if reach.private {
            arguments.push("private: &mut Private".to_owned());
        }
        for (argument, name) in self.function.arguments.iter().zip(&self.arguments) {
            arguments.push(format!("{}: {}", name.code, self.argument_type(argument.ty)?));
        }
        let result = match &self.function.result {
            Some(result) => format!(" -> {}", rust_type(self.module, self.names, result.ty)?),
            None => String::new(),
        };
        Ok(format!("{keyword} {name}({}){result}", arguments.join(", ")))
    }

    fn argument_type(&self, ty: Handle<Type>) -> Result<String> {
        match self.argument_pointee(ty) {
            Some(pointee) => Ok(format!("&mut {}", rust_type(self.module, self.names, pointee)?)),
            None => rust_type(self.module, self.names, ty),
        }
    }

    /// Whether the function itself, not only what it calls, has places in storage.
    fn accesses_storage(&self) -> bool {
        self.function.expressions.iter().any(|(_, expression)| match *expression {
            Expression::GlobalVariable(global) => {
                matches!(
                    self.module.global_variables[global].space,
                    AddressSpace::Storage { .. } | AddressSpace::Handle
                )
            }
            _ => false,
        })
    }

    /// Declares the local variables that no store declares.
    fn head_locals(&mut self) -> Result<()> {
        let function = self.function;
        for (handle, local) in function.local_variables.iter() {
            if self.schedule.is_declared_by_store(handle) {
                continue;
            }
            let ty = rust_type(self.module, self.names, local.ty)
                .map_err(|e| e.or_at(function.local_variables.get_span(handle)))?;
            let value = match local.init {
                Some(init) => self.compute(init)?.code,
                None => "rt::zero()".to_owned(),
            };
            self.line(&format!("let mut {}: {ty} = {value};", self.locals[&handle]));
        }
        Ok(())
    }

    /// Writes a line at the current depth.
    pub(super) fn line(&mut self, text: &str) {
        self.code.push_str(&"    ".repeat(self.indent));
        self.code.push_str(text);
        self.code.push('\n');
    }
}
