//! Where each expression of a function is written: at its only use, or in a `let` of its own.
//!
//! naga evaluates expressions where an `Emit` statement says so. Between one statement that acts
//! (a store, a call) and the next, nothing changes: a *run*. An expression may be written at its
//! only use if that is in the same run.

use std::collections::{HashMap, HashSet};

use naga::{
    Block, Expression, Function, Handle, LocalVariable, Module, Statement, TypeInner, valid::FunctionInfo,
};

use super::reach::inner_blocks;

type Run = u32;

/// Expressions longer than this are not written inside others.
const LONG: usize = 100;

/// The use of an expression that has only one.
#[derive(Clone, Copy)]
enum Use {
    Expression(Handle<Expression>),
    /// The statement that ends a run; `None` where the operand must have a name.
    Statement(Option<Run>),
}

/// The schedule of one function.
pub(super) struct Schedule {
    inlined: HashSet<Handle<Expression>>,
    /// Those of them that a statement uses itself.
    operands: HashSet<Handle<Expression>>,
    /// Local variables that begin with a store, by that statement.
    declarations: HashMap<*const Statement, Handle<LocalVariable>>,
    declared: HashSet<Handle<LocalVariable>>,
    /// Expressions that only give local variables their first value.
    initial: HashSet<Handle<Expression>>,
}

impl Schedule {
    pub(super) fn new(module: &Module, function: &Function, info: &FunctionInfo) -> Self {
        let mut walk =
            Walk { module, function, info, uses: HashMap::new(), runs: HashMap::new(), next_run: 0 };
        walk.block(&function.body, None);
        for (handle, expression) in function.expressions.iter() {
            for operand in operands(expression) {
                walk.uses.insert(operand, Use::Expression(handle));
            }
        }
        let inlined =
            walk.runs.keys().copied().filter(|&handle| walk.is_inlined(handle)).collect::<HashSet<_>>();
        let is_operand =
            |handle: &Handle<Expression>| matches!(walk.uses.get(handle), Some(Use::Statement(_)));
        let operands = inlined.iter().copied().filter(is_operand).collect();
        let declarations = Locals::new(function).declarations(&function.body);
        let declared = declarations.values().copied().collect();
        let initial = function.local_variables.iter().filter_map(|(_, local)| local.init);
        let initial = initial.filter(|&value| info[value].ref_count == 1).collect();
        Self { inlined, operands, declarations, declared, initial }
    }

    /// Whether an expression that takes `length` bytes is written at its only use: in another
    /// expression, only if it is short.
    pub(super) fn is_inlined(&self, expression: Handle<Expression>, length: usize) -> bool {
        let is_readable = length <= LONG || self.operands.contains(&expression);
        is_readable && self.inlined.contains(&expression)
    }

    /// Whether the expression only gives a local variable its first value.
    pub(super) fn is_initial(&self, expression: Handle<Expression>) -> bool {
        self.initial.contains(&expression)
    }

    /// The local variable that this statement declares by its first store.
    pub(super) fn declared_by(&self, statement: &Statement) -> Option<Handle<LocalVariable>> {
        self.declarations.get(&std::ptr::from_ref(statement)).copied()
    }

    /// Whether some statement declares the variable; if none does, the function's head must.
    pub(super) fn is_declared_by_store(&self, local: Handle<LocalVariable>) -> bool {
        self.declared.contains(&local)
    }
}

struct Walk<'a> {
    module: &'a Module,
    function: &'a Function,
    info: &'a FunctionInfo,
    uses: HashMap<Handle<Expression>, Use>,
    runs: HashMap<Handle<Expression>, Run>,
    next_run: Run,
}

impl Walk<'_> {
    fn block(&mut self, block: &Block, condition_at_end: Option<Handle<Expression>>) {
        let mut run = self.start_run();
        for statement in block {
            if let Statement::Emit(range) = statement {
                self.runs.extend(range.clone().map(|handle| (handle, run)));
                continue;
            }
            let end = Use::Statement(Some(run).filter(|_| !self.borrows(statement)));
            for operand in statement_operands(statement) {
                self.uses.insert(operand, end);
            }
            match statement {
                Statement::Loop { body, continuing, break_if } => {
                    self.block(body, None);
                    self.block(continuing, *break_if);
                }
                other => inner_blocks(other).into_iter().for_each(|inner| self.block(inner, None)),
            }
            run = self.start_run();
        }
        if let Some(condition) = condition_at_end {
            self.uses.insert(condition, Use::Statement(Some(run)));
        }
    }

    fn start_run(&mut self) -> Run {
        self.next_run += 1;
        self.next_run
    }

    /// Whether the statement borrows variables, so that its operands must not read them.
    fn borrows(&self, statement: &Statement) -> bool {
        match statement {
            Statement::Call { arguments, .. } => arguments.iter().any(|&argument| self.is_pointer(argument)),
            _ => false,
        }
    }

    fn is_pointer(&self, expression: Handle<Expression>) -> bool {
        self.info[expression].ty.inner_with(&self.module.types).pointer_space().is_some()
    }

    fn is_vector(&self, expression: Handle<Expression>) -> bool {
        matches!(self.info[expression].ty.inner_with(&self.module.types), TypeInner::Vector { .. })
    }

    fn is_inlined(&self, expression: Handle<Expression>) -> bool {
        self.info[expression].ref_count == 1
            && !self.function.named_expressions.contains_key(&expression)
            && self.runs.get(&expression).is_some_and(|&run| self.is_used_once_in(expression, run))
    }

    /// Whether the one use of `expression` writes it once, before the end of `run`.
    fn is_used_once_in(&self, expression: Handle<Expression>, run: Run) -> bool {
        match self.uses.get(&expression) {
            Some(Use::Statement(end)) => *end == Some(run),
            Some(&Use::Expression(user)) => {
                self.runs.get(&user) == Some(&run)
                    && !self.repeats(user, expression)
                    && (!self.is_written_at_each_use(user)
                        || self.info[user].ref_count == 1 && self.is_used_once_in(user, run))
            }
            None => false,
        }
    }

    /// Whether `user` writes its operand more than once.
    fn repeats(&self, user: Handle<Expression>, operand: Handle<Expression>) -> bool {
        match self.function.expressions[user] {
            Expression::Swizzle { .. } => true,
            Expression::Compose { .. } => {
                let is_swizzle = matches!(self.function.expressions[operand], Expression::Swizzle { .. });
                self.is_vector(user) && self.is_vector(operand) && !is_swizzle
            }
            _ => false,
        }
    }

    fn is_written_at_each_use(&self, expression: Handle<Expression>) -> bool {
        is_trivial(&self.function.expressions[expression]) || self.is_pointer(expression)
    }
}

/// Whether naming the expression would only add noise.
pub(super) fn is_trivial(expression: &Expression) -> bool {
    matches!(
        expression,
        Expression::Literal(_)
            | Expression::Constant(_)
            | Expression::Override(_)
            | Expression::ZeroValue(_)
            | Expression::FunctionArgument(_)
            | Expression::GlobalVariable(_)
            | Expression::LocalVariable(_)
            | Expression::AccessIndex { .. }
            | Expression::Splat { .. }
    )
}

/// The expressions that an expression is made of.
pub(super) fn operands(expression: &Expression) -> Vec<Handle<Expression>> {
    match *expression {
        Expression::Compose { ref components, .. } => components.clone(),
        Expression::Access { base, index } => vec![base, index],
        Expression::AccessIndex { base, .. } => vec![base],
        Expression::Splat { value, .. } => vec![value],
        Expression::Swizzle { vector, .. } => vec![vector],
        Expression::Load { pointer } => vec![pointer],
        Expression::Unary { expr, .. } | Expression::As { expr, .. } => vec![expr],
        Expression::Binary { left, right, .. } => vec![left, right],
        Expression::Select { condition, accept, reject } => vec![condition, accept, reject],
        Expression::Relational { argument, .. } => vec![argument],
        Expression::Math { arg, arg1, arg2, arg3, .. } => {
            [Some(arg), arg1, arg2, arg3].into_iter().flatten().collect()
        }
        Expression::ArrayLength(array) => vec![array],
        Expression::ImageLoad { image, coordinate, array_index, .. } => {
            [Some(image), Some(coordinate), array_index].into_iter().flatten().collect()
        }
        _ => Vec::new(),
    }
}

/// The expressions that a statement itself uses, without its blocks.
fn statement_operands(statement: &Statement) -> Vec<Handle<Expression>> {
    match *statement {
        Statement::If { condition, .. } => vec![condition],
        Statement::Switch { selector, .. } => vec![selector],
        Statement::Return { value } => value.into_iter().collect(),
        Statement::Store { pointer, value } => vec![pointer, value],
        Statement::Atomic { pointer, fun, value, .. } => match fun {
            naga::AtomicFunction::Exchange { compare: Some(compare) } => vec![pointer, compare, value],
            _ => vec![pointer, value],
        },
        Statement::Call { ref arguments, .. } => arguments.clone(),
        _ => Vec::new(),
    }
}

/// Those of `expressions` that `block`, or the condition at its end, needs by name.
pub(super) fn used_in(
    function: &Function,
    block: &Block,
    break_if: Option<Handle<Expression>>,
    expressions: &HashSet<Handle<Expression>>,
) -> HashSet<Handle<Expression>> {
    let mut used = HashSet::new();
    let mut pending: Vec<_> = break_if.into_iter().collect();
    let mut blocks = vec![block];
    while let Some(block) = blocks.pop() {
        for statement in block {
            pending.extend(statement_operands(statement));
            if let Statement::Loop { break_if: Some(condition), .. } = statement {
                pending.push(*condition);
            }
            blocks.extend(inner_blocks(statement));
        }
    }
    let mut seen = HashSet::new();
    while let Some(expression) = pending.pop() {
        if seen.insert(expression) {
            if expressions.contains(&expression) {
                used.insert(expression);
            } else {
                pending.extend(operands(&function.expressions[expression]));
            }
        }
    }
    used
}

/// The expressions that get their value in `block` itself, not in blocks inside it.
pub(super) fn evaluated_in(block: &Block) -> HashSet<Handle<Expression>> {
    let mut evaluated = HashSet::new();
    for statement in block {
        match statement {
            Statement::Emit(range) => evaluated.extend(range.clone()),
            Statement::Call { result, .. } | Statement::Atomic { result, .. } => evaluated.extend(*result),
            _ => {}
        }
    }
    evaluated
}

/// `&&` or `||`, for which naga has no expression: an `if` that stores to a variable of its own.
pub(super) struct Logical<'a> {
    /// The variable.
    pub(super) local: Handle<LocalVariable>,
    /// Whether it is `||`.
    pub(super) is_or: bool,
    /// What computes the right operand.
    pub(super) right: &'a Block,
}

/// The short-circuit operator that a statement is, if it is one.
pub(super) fn logical<'a>(function: &Function, statement: &'a Statement) -> Option<Logical<'a>> {
    let Statement::If { accept, reject, .. } = statement else { return None };
    let stored = |block: &Block| match block.last() {
        Some(&Statement::Store { pointer, value }) => match function.expressions[pointer] {
            Expression::LocalVariable(local) => Some((local, value)),
            _ => None,
        },
        _ => None,
    };
    let (local, _) = stored(accept)?;
    let (same, otherwise) = stored(reject)?;
    let short = match function.expressions[otherwise] {
        Expression::Literal(naga::Literal::Bool(value)) => value,
        _ => return None,
    };
    let is_own = local == same && function.local_variables[local].name.is_none() && reject.len() == 1;
    is_own.then_some(Logical { local, is_or: short, right: accept })
}

/// Finds the local variables that can be declared where they are first stored: all other uses come
/// later in the same block or inside it.
struct Locals<'a> {
    function: &'a Function,
    /// The outermost statements, of the block being looked at, that use the variable.
    total: HashMap<Handle<LocalVariable>, usize>,
}

impl<'a> Locals<'a> {
    fn new(function: &'a Function) -> Self {
        let mut locals = Self { function, total: HashMap::new() };
        locals.total = locals.count(&function.body);
        locals
    }

    fn declarations(&self, block: &Block) -> HashMap<*const Statement, Handle<LocalVariable>> {
        let mut found = HashMap::new();
        let mut seen = HashSet::new();
        let here = self.count(block);
        for statement in block {
            if let Some(local) = self.whole_store(statement) {
                let fresh = self.function.local_variables[local].init.is_none() && !seen.contains(&local);
                if fresh && here.get(&local) == self.total.get(&local) {
                    found.insert(std::ptr::from_ref(statement), local);
                }
            }
            if let Some(logical) = logical(self.function, statement) {
                found.insert(std::ptr::from_ref(statement), logical.local);
            }
            for inner in inner_blocks(statement) {
                found.extend(self.declarations(inner));
                seen.extend(self.count(inner).into_keys());
            }
            seen.extend(self.used_by(statement));
        }
        found
    }

    fn whole_store(&self, statement: &Statement) -> Option<Handle<LocalVariable>> {
        match *statement {
            Statement::Store { pointer, .. } => match self.function.expressions[pointer] {
                Expression::LocalVariable(local) => Some(local),
                _ => None,
            },
            _ => None,
        }
    }

    /// How often each variable is used in a block and inside it.
    fn count(&self, block: &Block) -> HashMap<Handle<LocalVariable>, usize> {
        let mut counts = HashMap::new();
        for statement in block {
            for local in self.used_by(statement) {
                *counts.entry(local).or_default() += 1;
            }
            for (local, count) in inner_blocks(statement).into_iter().flat_map(|inner| self.count(inner)) {
                *counts.entry(local).or_default() += count;
            }
        }
        counts
    }

    /// The variables whose pointers a statement evaluates or uses.
    fn used_by(&self, statement: &Statement) -> Vec<Handle<LocalVariable>> {
        let evaluated = match statement {
            Statement::Emit(range) => {
                range.clone().flat_map(|e| operands(&self.function.expressions[e])).collect()
            }
            other => statement_operands(other),
        };
        evaluated.into_iter().filter_map(|expression| self.root(expression)).collect()
    }

    fn root(&self, expression: Handle<Expression>) -> Option<Handle<LocalVariable>> {
        match self.function.expressions[expression] {
            Expression::LocalVariable(local) => Some(local),
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => self.root(base),
            _ => None,
        }
    }
}
