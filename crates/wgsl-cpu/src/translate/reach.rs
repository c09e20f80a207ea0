//! What an entry point reaches.

use std::collections::HashSet;

use naga::{Block, Constant, Expression, Function, Handle, Module, Statement, Type, TypeInner};

/// The functions that `function` calls, directly or not.
pub(super) fn called_functions(module: &Module, function: &Function) -> HashSet<Handle<Function>> {
    let mut reached = HashSet::new();
    let mut pending = calls(&function.body);
    while let Some(callee) = pending.pop() {
        if reached.insert(callee) {
            pending.extend(calls(&module.functions[callee].body));
        }
    }
    reached
}

fn calls(block: &Block) -> Vec<Handle<Function>> {
    let mut found = Vec::new();
    for statement in block {
        if let Statement::Call { function, .. } = statement {
            found.push(*function);
        }
        for inner in inner_blocks(statement) {
            found.extend(calls(inner));
        }
    }
    found
}

/// The blocks inside a statement.
pub(super) fn inner_blocks(statement: &Statement) -> Vec<&Block> {
    match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        Statement::Loop { body, continuing, .. } => vec![body, continuing],
        _ => Vec::new(),
    }
}

/// The named constants that functions and other constants' values refer to.
pub(super) fn used_constants<'a>(
    module: &Module,
    functions: impl Iterator<Item = &'a Function>,
    initial_values: impl Iterator<Item = Handle<Expression>>,
) -> HashSet<Handle<Constant>> {
    let mut used = HashSet::new();
    let mut pending: Vec<_> =
        functions.flat_map(|f| f.expressions.iter()).filter_map(|(_, e)| named(e)).collect();
    for value in initial_values {
        constants_of(module, value, &mut pending);
    }
    while let Some(constant) = pending.pop() {
        if used.insert(constant) {
            constants_of(module, module.constants[constant].init, &mut pending);
        }
    }
    used
}

fn named(expression: &Expression) -> Option<Handle<Constant>> {
    match *expression {
        Expression::Constant(constant) => Some(constant),
        _ => None,
    }
}

fn constants_of(module: &Module, value: Handle<Expression>, found: &mut Vec<Handle<Constant>>) {
    match &module.global_expressions[value] {
        Expression::Compose { components, .. } => {
            components.iter().for_each(|&part| constants_of(module, part, found));
        }
        Expression::Splat { value, .. } => constants_of(module, *value, found),
        expression => found.extend(named(expression)),
    }
}

/// Adds a type and those that it is made of.
pub(super) fn add_type(module: &Module, ty: Handle<Type>, types: &mut HashSet<Handle<Type>>) {
    if !types.insert(ty) {
        return;
    }
    match &module.types[ty].inner {
        TypeInner::Array { base, .. } | TypeInner::Pointer { base, .. } => add_type(module, *base, types),
        TypeInner::Struct { members, .. } => {
            members.iter().for_each(|member| add_type(module, member.ty, types));
        }
        _ => {}
    }
}
