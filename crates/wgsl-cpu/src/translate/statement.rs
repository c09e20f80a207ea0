//! Statements as Rust.

use naga::{AtomicFunction, Block, Expression, Handle, Span, Statement};

use super::{
    error::{Result, Unsupported},
    expression::Text,
    function::FunctionWriter,
    schedule::{is_trivial, logical},
    types::rust_type,
};

impl FunctionWriter<'_> {
    /// Writes a block's statements; `is_tail` if the function ends with it.
    pub(super) fn block(&mut self, block: &Block, is_tail: bool) -> Result<()> {
        for (at, (statement, &span)) in block.span_iter().enumerate() {
            let is_last = is_tail && at + 1 == block.len();
            self.statement(statement, is_last).map_err(|unsupported| unsupported.or_at(span))?;
        }
        Ok(())
    }

    pub(super) fn indented(&mut self, write: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.indent += 1;
        let written = write(self);
        self.indent -= 1;
        written
    }

    pub(super) fn statement(&mut self, statement: &Statement, is_last: bool) -> Result<()> {
        match *statement {
            Statement::Emit(ref range) => range.clone().try_for_each(|expression| self.emit(expression)),
            // All names of a function differ, so that scopes need no braces.
            Statement::Block(ref block) => self.block(block, false),
            Statement::If { condition, ref accept, ref reject } => match logical(self.function, statement) {
                Some(logical) => self.logical(condition, &logical),
                None => self.branch(condition, accept, reject),
            },
            Statement::Switch { selector, ref cases } => self.switch(selector, cases),
            Statement::Loop { ref body, ref continuing, break_if } => self.repeat(body, continuing, break_if),
            Statement::Break => {
                self.leave();
                Ok(())
            }
            Statement::Continue => {
                self.next_iteration();
                Ok(())
            }
            Statement::Return { value } => self.finish(value, is_last),
            Statement::Store { pointer, value } => self.assign(statement, pointer, value),
            Statement::Atomic { pointer, fun, value, result } => self.modify(pointer, fun, value, result),
            Statement::Call { function, ref arguments, result } => self.call(function, arguments, result),
            ref other => Err(Unsupported::new(construct(other), Span::UNDEFINED)),
        }
    }

    /// Gives an expression its value here, unless it is written where it is used.
    fn emit(&mut self, expression: Handle<Expression>) -> Result<()> {
        let is_unused = self.info[expression].ref_count == 0 || self.schedule.is_initial(expression);
        if is_unused || !self.takes_name(expression) {
            return Ok(());
        }
        let text = self.compute(expression)?;
        if self.schedule.is_inlined(expression, text.code.len()) {
            self.values.insert(expression, text);
        } else {
            self.define(expression, &text.code);
        }
        Ok(())
    }

    /// Whether an expression is worth a name, or must have its value before it is used. Pointers
    /// are followed where they are used; their indexes are evaluated by then.
    pub(super) fn takes_name(&self, expression: Handle<Expression>) -> bool {
        let is_named = self.function.named_expressions.contains_key(&expression);
        let is_pointer = self.inner(expression).pointer_space().is_some();
        !is_pointer && (is_named || !is_trivial(&self.function.expressions[expression]))
    }

    /// `let name = code;`
    pub(super) fn define(&mut self, expression: Handle<Expression>, code: &str) {
        match self.values.get(&expression) {
            // Declared before, because the end of the loop's body needs it too.
            Some(name) => {
                let assignment = format!("{} = {code};", name.code);
                self.line(&assignment);
            }
            None => {
                let name = self.name(expression);
                self.line(&format!("let {name} = {code};"));
            }
        }
    }

    /// Chooses an expression's name.
    pub(super) fn name(&mut self, expression: Handle<Expression>) -> String {
        let named = self.function.named_expressions.get(&expression);
        let name = match named {
            Some(name) => self.scope.unique(name),
            None => self.scope.unique(&format!("e{}", expression.index())),
        };
        self.values.insert(expression, Text::atom(&name));
        name
    }

    fn finish(&mut self, value: Option<Handle<Expression>>, is_last: bool) -> Result<()> {
        match (value, is_last) {
            (Some(value), true) => {
                let code = self.value(value)?.code;
                self.line(&code);
            }
            (Some(value), false) => {
                let code = self.value(value)?.code;
                self.line(&format!("return {code};"));
            }
            (None, true) => {}
            (None, false) => self.line("return;"),
        }
        Ok(())
    }

    fn assign(
        &mut self,
        statement: &Statement,
        pointer: Handle<Expression>,
        value: Handle<Expression>,
    ) -> Result<()> {
        let text = self.value(value)?;
        let code = match self.schedule.declared_by(statement) {
            Some(local) => {
                let ty = self.function.local_variables[local].ty;
                let ty = rust_type(self.module, self.names, ty)?;
                format!("let mut {}: {ty} = {};", self.locals[&local], text.code)
            }
            None => self.store(pointer, &text)?,
        };
        self.line(&code);
        Ok(())
    }

    fn modify(
        &mut self,
        pointer: Handle<Expression>,
        function: AtomicFunction,
        value: Handle<Expression>,
        result: Option<Handle<Expression>>,
    ) -> Result<()> {
        let atomic = self.atomic(pointer)?;
        let value = self.value(value)?.code;
        let call = match function {
            AtomicFunction::Add => format!("fetch_add({value})"),
            AtomicFunction::Subtract => format!("fetch_sub({value})"),
            AtomicFunction::And => format!("fetch_and({value})"),
            AtomicFunction::ExclusiveOr => format!("fetch_xor({value})"),
            AtomicFunction::InclusiveOr => format!("fetch_or({value})"),
            AtomicFunction::Min => format!("fetch_min({value})"),
            AtomicFunction::Max => format!("fetch_max({value})"),
            AtomicFunction::Exchange { compare: None } => format!("exchange({value})"),
            AtomicFunction::Exchange { compare: Some(compare) } => {
                format!("compare_exchange({}, {value})", self.value(compare)?.code)
            }
        };
        self.result(result, &format!("{atomic}.{call}"));
        Ok(())
    }

    /// Evaluates `code`, as `result` if that is used.
    pub(super) fn result(&mut self, result: Option<Handle<Expression>>, code: &str) {
        match result.filter(|&result| self.info[result].ref_count > 0) {
            Some(result) => self.define(result, code),
            None => self.line(&format!("{code};")),
        }
    }
}

/// What a statement that kernels cannot have is called.
fn construct(statement: &Statement) -> &'static str {
    match statement {
        Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => "a barrier",
        Statement::WorkGroupUniformLoad { .. } => "workgroup memory",
        Statement::ImageStore { .. } | Statement::ImageAtomic { .. } => "a texture",
        Statement::SubgroupBallot { .. }
        | Statement::SubgroupGather { .. }
        | Statement::SubgroupCollectiveOperation { .. } => "a subgroup operation",
        Statement::RayQuery { .. } | Statement::RayPipelineFunction(_) => "a ray query",
        Statement::Kill => "discard",
        _ => "this statement",
    }
}
