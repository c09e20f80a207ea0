//! Statements as Rust.

use std::collections::HashSet;

use naga::{
    AddressSpace, AtomicFunction, Block, Expression, Function, Handle, Span, Statement, SwitchCase,
    SwitchValue,
};

use super::{
    error::{Result, Unsupported},
    expression::Text,
    function::{FunctionWriter, Reach},
    place::Place,
    schedule::{Logical, evaluated_in, is_trivial, logical, used_in},
    types::rust_type,
};

/// A loop or a switch around the statement being written.
pub(super) struct Frame {
    /// The number in its labels.
    number: usize,
    kind: FrameKind,
    /// Whether its label is used.
    is_labelled: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum FrameKind {
    Switch,
    /// A loop whose body, if `is_block`, is a labelled block that `continue` leaves.
    Loop {
        is_block: bool,
    },
}

impl FunctionWriter<'_> {
    /// Writes a block's statements; `is_tail` if the function ends with it.
    pub(super) fn block(&mut self, block: &Block, is_tail: bool) -> Result<()> {
        for (at, (statement, &span)) in block.span_iter().enumerate() {
            let is_last = is_tail && at + 1 == block.len();
            self.statement(statement, is_last).map_err(|unsupported| unsupported.or_at(span))?;
        }
        Ok(())
    }

    fn indented(&mut self, write: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.indent += 1;
        let written = write(self);
        self.indent -= 1;
        written
    }

    fn statement(&mut self, statement: &Statement, is_last: bool) -> Result<()> {
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
        if self.schedule.is_inlined(expression) && text.code.len() <= 100 {
            self.values.insert(expression, text);
        } else {
            self.define(expression, &text.code);
        }
        Ok(())
    }

    /// Whether an expression is worth a name, or must have its value before it is used. Pointers
    /// are followed where they are used; their indexes are evaluated by then.
    fn takes_name(&self, expression: Handle<Expression>) -> bool {
        let is_named = self.function.named_expressions.contains_key(&expression);
        let is_pointer = self.inner(expression).pointer_space().is_some();
        !is_pointer && (is_named || !is_trivial(&self.function.expressions[expression]))
    }

    /// `let name = code;`
    fn define(&mut self, expression: Handle<Expression>, code: &str) {
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
    fn name(&mut self, expression: Handle<Expression>) -> String {
        let named = self.function.named_expressions.get(&expression);
        let name = match named {
            Some(name) => self.scope.unique(name),
            None => self.scope.unique(&format!("e{}", expression.index())),
        };
        self.values.insert(expression, Text::atom(&name));
        name
    }

    /// `&&` and `||`.
    fn logical(&mut self, condition: Handle<Expression>, logical: &Logical<'_>) -> Result<()> {
        let left = match (logical.is_or, &self.function.expressions[condition]) {
            // naga negates the left operand of `||`.
            (true, &Expression::Unary { op: naga::UnaryOperator::LogicalNot, expr }) => self.value(expr)?,
            (true, _) => Text::compound(format!("!{}", self.value(condition)?.operand())),
            (false, _) => self.value(condition)?,
        };
        let symbol = if logical.is_or { "||" } else { "&&" };
        let head = format!("{} {symbol} ", left.operand());
        let (right, statements) = self.aside(|this| this.right_operand(logical))?;
        if statements.is_empty() {
            // naga loads the variable at once: that is where the operator is written.
            let text = Text::compound(head + &right.operand());
            self.logicals.insert(logical.local, text);
            return Ok(());
        }
        self.line(&format!("let {} = {head}{{", self.locals[&logical.local]));
        self.code.push_str(&statements);
        self.indented(|this| {
            this.line(&right.code);
            Ok(())
        })?;
        self.line("};");
        Ok(())
    }

    /// Writes to a text of its own.
    fn aside<T>(&mut self, write: impl FnOnce(&mut Self) -> Result<T>) -> Result<(T, String)> {
        let before = std::mem::take(&mut self.code);
        let written = write(self);
        let code = std::mem::replace(&mut self.code, before);
        Ok((written?, code))
    }

    /// Writes what the right operand needs, and returns it.
    fn right_operand(&mut self, logical: &Logical<'_>) -> Result<Text> {
        let mut right = Text::atom("false");
        self.indented(|this| {
            for (statement, &span) in logical.right.span_iter() {
                match *statement {
                    Statement::Store { value, .. }
                        if std::ptr::eq(statement, &logical.right[logical.right.len() - 1]) =>
                    {
                        right = this.value(value)?;
                    }
                    _ => this.statement(statement, false).map_err(|unsupported| unsupported.or_at(span))?,
                }
            }
            Ok(())
        })?;
        Ok(right)
    }

    fn branch(&mut self, condition: Handle<Expression>, accept: &Block, reject: &Block) -> Result<()> {
        let condition = self.value(condition)?;
        if accept.is_empty() {
            self.line(&format!("if !{} {{", condition.operand()));
            self.indented(|this| this.block(reject, false))?;
        } else {
            self.line(&format!("if {} {{", condition.code));
            self.indented(|this| this.block(accept, false))?;
            self.otherwise(reject)?;
        }
        self.line("}");
        Ok(())
    }

    /// The `else` of an `if`, joined with an `if` that it consists of.
    fn otherwise(&mut self, reject: &Block) -> Result<()> {
        if reject.is_empty() {
            return Ok(());
        }
        let ((), inside) = self.aside(|this| this.indented(|this| this.block(reject, false)))?;
        let depth = "    ".repeat(self.indent);
        let is_chain = matches!(reject.last(), Some(Statement::If { .. })) && is_one_branch(&inside, &depth);
        if is_chain {
            // The inner `if` moves out by one level and its last brace is the outer one's.
            let moved: String = inside.lines().map(|line| format!("{}\n", &line[4..])).collect();
            let body = moved.trim_end().strip_suffix('}').unwrap_or(&moved).trim_end();
            self.code.push_str(&format!("{depth}}} else {}\n", body.trim_start()));
        } else {
            self.line("} else {");
            self.code.push_str(&inside);
        }
        Ok(())
    }

    fn switch(&mut self, selector: Handle<Expression>, cases: &[SwitchCase]) -> Result<()> {
        let selector = self.value(selector)?;
        let number = self.push_frame(FrameKind::Switch);
        let ((), arms) = self.aside(|this| this.indented(|this| this.arms(cases)))?;
        let is_labelled = self.pop_frame();
        let label = if is_labelled { format!("'switch_{number}: {{ ") } else { String::new() };
        self.line(&format!("{label}match {} {{", selector.code));
        self.code.push_str(&arms);
        self.line(if is_labelled { "} }" } else { "}" });
        Ok(())
    }

    /// The arms of a `match`, the default one last.
    fn arms(&mut self, cases: &[SwitchCase]) -> Result<()> {
        let mut patterns = Vec::new();
        let mut arms: Vec<(String, &Block)> = Vec::new();
        let mut default = None;
        for case in cases {
            match case.value {
                SwitchValue::I32(value) => patterns.push(format!("{value}i32")),
                SwitchValue::U32(value) => patterns.push(format!("{value}u32")),
                SwitchValue::Default => patterns.push("_".to_owned()),
            }
            if case.fall_through {
                continue;
            }
            if patterns.iter().any(|pattern| pattern == "_") {
                default = Some(&case.body);
            } else {
                arms.push((patterns.join(" | "), &case.body));
            }
            patterns.clear();
        }
        arms.extend(default.map(|body| ("_".to_owned(), body)));
        for (pattern, body) in arms {
            self.line(&format!("{pattern} => {{"));
            self.indented(|this| this.arm(body))?;
            self.line("}");
        }
        Ok(())
    }

    /// An arm's statements without the `break` at their end.
    fn arm(&mut self, body: &Block) -> Result<()> {
        let is_break = |statement: &Statement| matches!(statement, Statement::Break);
        for (at, (statement, &span)) in body.span_iter().enumerate() {
            if at + 1 < body.len() || !is_break(statement) {
                self.statement(statement, false).map_err(|unsupported| unsupported.or_at(span))?;
            }
        }
        Ok(())
    }

    fn repeat(
        &mut self,
        body: &Block,
        continuing: &Block,
        break_if: Option<Handle<Expression>>,
    ) -> Result<()> {
        let has_end = !continuing.is_empty() || break_if.is_some();
        let is_block = has_end && has_continue(body);
        let hoisted = if is_block {
            let mut named = evaluated_in(body);
            named.retain(|&expression| self.takes_name(expression));
            used_in(self.function, continuing, break_if, &named)
        } else {
            HashSet::new()
        };
        let number = self.push_frame(FrameKind::Loop { is_block });
        let ((), inside) = self.aside(|this| {
            this.indented(|this| this.iteration(body, continuing, break_if, number, hoisted))
        })?;
        let label = if self.pop_frame() { format!("'loop_{number}: ") } else { String::new() };
        self.line(&format!("{label}loop {{"));
        self.code.push_str(&inside);
        self.line("}");
        Ok(())
    }

    fn iteration(
        &mut self,
        body: &Block,
        continuing: &Block,
        break_if: Option<Handle<Expression>>,
        number: usize,
        hoisted: HashSet<Handle<Expression>>,
    ) -> Result<()> {
        if self.frames.last().is_some_and(|frame| frame.kind == FrameKind::Loop { is_block: true }) {
            self.declare(hoisted)?;
            self.line(&format!("'continue_{number}: {{"));
            self.indented(|this| this.block(body, false))?;
            self.line("}");
        } else {
            self.block(body, false)?;
        }
        self.block(continuing, false)?;
        if let Some(condition) = break_if {
            let condition = self.value(condition)?.code;
            self.line(&format!("if {condition} {{ break; }}"));
        }
        Ok(())
    }

    /// Declares expressions that get their value in a block but outlive it.
    fn declare(&mut self, hoisted: HashSet<Handle<Expression>>) -> Result<()> {
        let mut hoisted: Vec<_> = hoisted.into_iter().collect();
        hoisted.sort_by_key(|expression| expression.index());
        for expression in hoisted {
            let ty = self.value_type(expression)?;
            let name = self.name(expression);
            self.line(&format!("let {name}: {ty};"));
        }
        Ok(())
    }

    fn push_frame(&mut self, kind: FrameKind) -> usize {
        self.n_labels += 1;
        self.frames.push(Frame { number: self.n_labels, kind, is_labelled: false });
        self.n_labels
    }

    /// Ends the innermost loop or switch and tells whether its label was used.
    fn pop_frame(&mut self) -> bool {
        self.frames.pop().is_some_and(|frame| frame.is_labelled)
    }

    /// `break`, out of the innermost loop or switch.
    fn leave(&mut self) {
        let Some(frame) = self.frames.last_mut() else { return };
        let code = match frame.kind {
            FrameKind::Loop { is_block: false } => "break;".to_owned(),
            FrameKind::Loop { is_block: true } => format!("break 'loop_{};", frame.number),
            FrameKind::Switch => format!("break 'switch_{};", frame.number),
        };
        frame.is_labelled |= frame.kind != FrameKind::Loop { is_block: false };
        self.line(&code);
    }

    /// `continue`, of the innermost loop, out of any switch.
    fn next_iteration(&mut self) {
        let in_switch = self.frames.last().is_some_and(|frame| frame.kind == FrameKind::Switch);
        let innermost = self.frames.iter_mut().rev().find(|frame| frame.kind != FrameKind::Switch);
        let Some(frame) = innermost else { return };
        let code = match frame.kind {
            FrameKind::Loop { is_block: true } => format!("break 'continue_{};", frame.number),
            _ if in_switch => {
                frame.is_labelled = true;
                format!("continue 'loop_{};", frame.number)
            }
            _ => "continue;".to_owned(),
        };
        self.line(&code);
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
    fn result(&mut self, result: Option<Handle<Expression>>, code: &str) {
        match result.filter(|&result| self.info[result].ref_count > 0) {
            Some(result) => self.define(result, code),
            None => self.line(&format!("{code};")),
        }
    }

    fn call(
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

/// Whether lines of code one level inside `depth` are one `if` with its `else`s.
fn is_one_branch(inside: &str, depth: &str) -> bool {
    let at_level = |line: &str| !line.starts_with(&format!("{depth}        "));
    let heads: Vec<&str> = inside.lines().filter(|line| at_level(line)).map(str::trim_start).collect();
    heads.first().is_some_and(|head| head.starts_with("if "))
        && heads[1..].iter().all(|head| head.starts_with('}'))
}

/// Whether a `continue` in the block, but not in a loop inside it, ends the iteration.
fn has_continue(block: &Block) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Continue => true,
        Statement::Loop { .. } => false,
        other => super::reach::inner_blocks(other).into_iter().any(has_continue),
    })
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
