//! Mutation testing of the kernels: each mistake in a table is built into them, and the proofs must
//! notice.

mod suite;
mod table;

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    time::Instant,
};

use anyhow::{Context, Result, ensure};
use clap::Args;

use suite::{Suite, Verdict};
use table::{MUTANTS, Mutant};

/// `cargo xtask mutants`.
#[derive(Args, Debug)]
pub struct MutantsArgs {
    /// Only these mutants, by name.
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Print the mutants and stop.
    #[arg(long)]
    list: bool,
}

/// Whether the proofs caught every mutant.
///
/// # Errors
/// If a name is unknown, the proofs do not pass unmutated, or a mutant does not compile.
pub fn run(args: &MutantsArgs) -> Result<bool> {
    let chosen = choose(&args.only)?;
    if args.list {
        chosen.iter().for_each(|m| println!("{:<38} {}", m.name, m.file));
        return Ok(true);
    }
    check_unmutated(&chosen)?;
    let mut survivors = 0;
    for mutant in &chosen {
        let start = Instant::now();
        let suite = Suite::build(Some(mutant)).with_context(|| mutant.name)?;
        let (word, detail) = match suite.run(mutant.caught_by).with_context(|| mutant.name)? {
            Verdict::Failed(test) => ("caught", test),
            Verdict::Passed(n) => ("SURVIVED", format!("{n} proofs")),
        };
        survivors += usize::from(word == "SURVIVED");
        println!("{:<38} {word:<9} {detail} ({:.0} s)", mutant.name, start.elapsed().as_secs_f64());
    }
    println!("{} of {} mutants caught", chosen.len() - survivors, chosen.len());
    Ok(survivors == 0)
}

fn choose(names: &[String]) -> Result<Vec<Mutant>> {
    let find = |name: &String| {
        let found = MUTANTS.iter().find(|mutant| mutant.name == name);
        found.copied().with_context(|| format!("no mutant is called {name}; --list prints them"))
    };
    if names.is_empty() { Ok(MUTANTS.to_vec()) } else { names.iter().map(find).collect() }
}

/// What fails anyway catches nothing.
fn check_unmutated(chosen: &[Mutant]) -> Result<()> {
    let suite = Suite::build(None)?;
    let filters: BTreeSet<&str> = chosen.iter().map(|mutant| mutant.caught_by).collect();
    for filter in filters {
        let verdict = suite.run(filter)?;
        ensure!(
            matches!(verdict, Verdict::Passed(_)),
            "unmutated, the proofs \"{filter}\" fail: {verdict:?}"
        );
    }
    println!("unmutated, the proofs pass");
    Ok(())
}

/// The root of the repository.
fn workspace() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}
