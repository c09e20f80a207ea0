//! Calls as Rust.

use naga::{AddressSpace, Expression, Function, Handle, Span};

use super::{
    error::{Result, Unsupported},
    function::{FunctionWriter, Reach},
    place::Place,
};

impl FunctionWriter<'_> {
    pub(super) fn call(
        &mut self,
        function: Handle<Function>,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
    ) -> Result<()> {
        self.refuse_aliases(function, arguments)?;
        let reach = Reach::new(self.module, &self.module_info[function]);
        let mut codes = Vec::new();
        codes.extend(reach.globals.then(|| "globals".to_owned()));
        codes.extend(reach.private.then(|| "private".to_owned()));
        let mut copied_back = Vec::new();
        for &argument in arguments {
            match self.inner(argument).pointer_space() {
                None => codes.push(self.value(argument)?.code),
                Some(AddressSpace::Private) if reach.private && self.is_private(argument) => {
                    codes.push(self.copy_private(argument, &mut copied_back)?);
                }
                Some(_) => codes.push(self.reference(argument)?),
            }
        }
        let call = format!("{}({})", self.names.function(function), codes.join(", "));
        self.result(result, &call);
        for line in copied_back {
            self.line(&line);
        }
        Ok(())
    }

    fn reference(&self, argument: Handle<Expression>) -> Result<String> {
        let span = self.function.expressions.get_span(argument);
        self.place(argument)?.reference().ok_or_else(|| Unsupported::new("a pointer to this", span))
    }

    /// A callee that has all private variables cannot also have a reference to one: it gets one to
    /// a copy, which is the same where it does not use that variable itself.
    fn copy_private(&mut self, argument: Handle<Expression>, back: &mut Vec<String>) -> Result<String> {
        let Place::Variable { code, .. } = self.place(argument)? else {
            return self.reference(argument);
        };
        let copy = self.scope.unique("copy");
        self.line(&format!("let mut {copy} = {code};"));
        back.push(format!("{code} = {copy};"));
        Ok(format!("&mut {copy}"))
    }

    fn is_private(&self, pointer: Handle<Expression>) -> bool {
        matches!(self.root(pointer), Expression::GlobalVariable(_))
    }

    /// The variable or argument that a pointer leads into.
    fn root(&self, pointer: Handle<Expression>) -> &Expression {
        match self.function.expressions[pointer] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => self.root(base),
            ref root => root,
        }
    }

    /// Two ways to one variable: WGSL forbids it where one of them writes, naga does not look.
    fn refuse_aliases(&self, callee: Handle<Function>, arguments: &[Handle<Expression>]) -> Result<()> {
        let is_pointer = |argument: &&Handle<Expression>| self.inner(**argument).pointer_space().is_some();
        let roots: Vec<_> = arguments.iter().filter(is_pointer).map(|&pointer| self.root(pointer)).collect();
        for (at, &root) in roots.iter().enumerate() {
            if roots[..at].contains(&root) {
                return Err(Unsupported::new("passing two pointers into one variable", Span::UNDEFINED));
            }
            if let Expression::GlobalVariable(global) = *root
                && !self.module_info[callee][global].is_empty()
            {
                let construct = "passing a pointer to a variable that the function also uses";
                return Err(Unsupported::new(construct, Span::UNDEFINED));
            }
        }
        Ok(())
    }
}
