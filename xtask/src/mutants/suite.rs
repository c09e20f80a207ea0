//! Building the proofs, perhaps with a mutant in them, and running them.

use std::{
    fs::{self, File},
    path::PathBuf,
    process::{Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use super::{table::Mutant, workspace};

/// The package and the test binary that hold the proofs.
const PACKAGE: &str = "midway-tests";
const TEST: &str = "proofs";
/// A mutant may make paths endless: whoever takes this long is caught.
const TIME_LIMIT: Duration = Duration::from_secs(900);
/// Between two looks at the log.
const POLL: Duration = Duration::from_millis(200);

/// The proofs as built.
pub struct Suite {
    binary: PathBuf,
    log: PathBuf,
}

/// How the proofs ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// All passed, this many.
    Passed(usize),
    /// At least one failed; the first that did.
    Failed(String),
}

impl Suite {
    /// Builds the proofs in a target folder of their own.
    ///
    /// # Errors
    /// If they do not compile: a mutant must be a mistake of meaning.
    pub fn build(mutant: Option<&Mutant>) -> Result<Self> {
        let target = workspace().join("target/mutants");
        fs::create_dir_all(&target)?;
        let variable = mutant.map_or(String::new(), |m| format!("{}::{}=>{}", m.file, m.find, m.replace));
        let output = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()))
            .current_dir(workspace())
            .args(["test", "--release", "--no-run", "--message-format=json-render-diagnostics"])
            .args(["--package", PACKAGE, "--test", TEST, "--target-dir"])
            .arg(&target)
            .env("MIDWAY_MUTANT", variable)
            .stderr(Stdio::inherit())
            .output()
            .context("cargo cannot be run")?;
        ensure!(output.status.success(), "the proofs do not compile");
        let binary =
            executable(&String::from_utf8_lossy(&output.stdout)).context("cargo named no test binary")?;
        Ok(Self { binary, log: target.join("proofs.log") })
    }

    /// Runs the proofs whose name contains `filter`, until one fails.
    ///
    /// # Errors
    /// If the binary cannot be run, or passes without running a test.
    pub fn run(&self, filter: &str) -> Result<Verdict> {
        let log = File::create(&self.log)?;
        let mut child = Command::new(&self.binary)
            .current_dir(workspace().join("tests"))
            .args((!filter.is_empty()).then_some(filter))
            .stdout(log.try_clone()?)
            .stderr(log)
            .stdin(Stdio::null())
            .spawn()
            .with_context(|| self.binary.display().to_string())?;
        let start = Instant::now();
        while child.try_wait()?.is_none() {
            let failure = if start.elapsed() > TIME_LIMIT {
                Some(format!("not done after {} s", TIME_LIMIT.as_secs()))
            } else {
                first_failure(&self.read_log()?)
            };
            if let Some(failure) = failure {
                child.kill()?;
                child.wait()?;
                return Ok(Verdict::Failed(failure));
            }
            thread::sleep(POLL);
        }
        self.verdict(child.wait()?)
    }

    fn read_log(&self) -> Result<String> {
        Ok(String::from_utf8_lossy(&fs::read(&self.log)?).into_owned())
    }

    fn verdict(&self, status: ExitStatus) -> Result<Verdict> {
        let text = self.read_log()?;
        if !status.success() {
            return Ok(Verdict::Failed(first_failure(&text).unwrap_or_else(|| status.to_string())));
        }
        match n_passed(&text) {
            Some(n) if n > 0 => Ok(Verdict::Passed(n)),
            _ => bail!("no proof ran: see {}", self.log.display()),
        }
    }
}

/// The path of the one test binary in cargo's messages.
fn executable(messages: &str) -> Option<PathBuf> {
    messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok()).find_map(|message| {
        let is_test = message["profile"]["test"] == Value::Bool(true) && message["target"]["name"] == TEST;
        is_test.then(|| message["executable"].as_str().map(PathBuf::from))?
    })
}

/// The name in the first `test NAME ... FAILED`.
fn first_failure(log: &str) -> Option<String> {
    let name = |line: &str| Some(line.strip_prefix("test ")?.strip_suffix(" ... FAILED")?.to_owned());
    log.lines().find_map(name)
}

/// N of `test result: ok. N passed; …`.
fn n_passed(log: &str) -> Option<usize> {
    let line = log.lines().find_map(|line| line.strip_prefix("test result: ok. "))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logs_are_read() {
        let log = "running 2 tests\ntest a::b ... ok\ntest c ... FAILED\n\ntest result: FAILED. 1 passed";
        assert_eq!(first_failure(log).as_deref(), Some("c"));
        assert_eq!(n_passed(log), None);
        assert_eq!(n_passed("test result: ok. 12 passed; 0 failed;"), Some(12));
    }

    #[test]
    fn the_binary_is_found_in_cargos_messages() {
        let messages = r#"
            {"reason":"compiler-artifact","target":{"name":"midway_tests"},"profile":{"test":false},"executable":null}
            {"reason":"compiler-artifact","target":{"name":"proofs"},"profile":{"test":true},"executable":"/t/proofs-1"}
            {"reason":"build-finished","success":true}"#;
        assert_eq!(executable(messages), Some(PathBuf::from("/t/proofs-1")));
        assert_eq!(executable(""), None);
    }
}
