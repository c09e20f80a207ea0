//! Branches and loops as Rust.

use std::collections::HashSet;

use naga::{Block, Expression, Handle, Statement, SwitchCase, SwitchValue};

use super::{
    error::Result,
    expression::Text,
    function::FunctionWriter,
    schedule::{Logical, evaluated_in, used_in},
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
    /// `&&` and `||`.
    pub(super) fn logical(&mut self, condition: Handle<Expression>, logical: &Logical<'_>) -> Result<()> {
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
    pub(super) fn aside<T>(&mut self, write: impl FnOnce(&mut Self) -> Result<T>) -> Result<(T, String)> {
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

    pub(super) fn branch(
        &mut self,
        condition: Handle<Expression>,
        accept: &Block,
        reject: &Block,
    ) -> Result<()> {
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

    pub(super) fn switch(&mut self, selector: Handle<Expression>, cases: &[SwitchCase]) -> Result<()> {
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

    pub(super) fn repeat(
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
    pub(super) fn leave(&mut self) {
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
    pub(super) fn next_iteration(&mut self) {
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
