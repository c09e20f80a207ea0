//! Running `midway` in a folder of its own.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use midway_film::{Image, Metadata, write_exr};
use serde_json::Value;
use tempfile::TempDir;

/// No run of these tests takes longer unless it hangs.
const DEADLINE: Duration = Duration::from_secs(60);

/// A folder that goes away, and what one needs in it.
pub struct Sandbox(TempDir);

/// How a run ended.
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Sandbox {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    pub fn write_image(&self, name: &str, image: &Image) {
        write_exr(&self.path(name), image, None, &Metadata::new()).unwrap();
    }

    /// A grey wall under a light, both facing the camera that is framed on them.
    pub fn write_scene(&self) {
        self.write("scene.mtl", "newmtl light\nKe 4 3 2\nKd 0 0 0\nnewmtl wall\nKd 0.5 0.5 0.5\n");
        let wall = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
        let light = "v -1 1 0\nv 1 1 0\nv 1 1.5 0.5\nv -1 1.5 0.5\n";
        // Apart: of two faces in one place either may be hit.
        let back = "v -1 1 -0.02\nv 1 1 -0.02\nv 1 1.5 0.48\nv -1 1.5 0.48\n";
        let faces = "usemtl wall\nf 1 2 3 4\nusemtl light\nf 5 6 7 8\nf 12 11 10 9\n";
        self.write("scene.obj", format!("mtllib scene.mtl\n{wall}{light}{back}{faces}"));
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_midway"));
        command.args(arguments).current_dir(self.0.path()).env_remove("RUST_BACKTRACE");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs `midway`; one that does not end is killed and fails the test.
    pub fn run(&self, arguments: &[&str]) -> Run {
        let streams = tempfile::tempdir().unwrap();
        let [stdout, stderr] = ["stdout", "stderr"].map(|name| streams.path().join(name));
        let mut command = self.command(arguments);
        command.stdout(File::create(&stdout).unwrap()).stderr(File::create(&stderr).unwrap());
        let mut child = command.spawn().unwrap();
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            if start.elapsed() > DEADLINE {
                child.kill().unwrap();
                child.wait().unwrap();
                panic!("{arguments:?} hangs: {}", fs::read_to_string(&stderr).unwrap());
            }
            thread::sleep(Duration::from_millis(2));
        };
        Run {
            // A signal has no code; none of the tests expects one.
            code: status.code().unwrap_or(-1),
            stdout: fs::read_to_string(&stdout).unwrap(),
            stderr: fs::read_to_string(&stderr).unwrap(),
        }
    }

    /// Runs `midway` and checks the exit code.
    pub fn expect(&self, code: i32, arguments: &[&str]) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.code, code, "{arguments:?}: {}", run.stderr);
        run
    }

    pub fn exists(&self, name: &str) -> bool {
        Path::exists(&self.path(name))
    }
}

impl Run {
    /// The line that says why the program ended; it must be the only one of its kind.
    pub fn error(&self) -> &str {
        let lines: Vec<&str> =
            self.stderr.lines().filter(|line| line.starts_with("midway: error: ")).collect();
        assert_eq!(lines.len(), 1, "{}", self.stderr);
        lines[0]
    }

    /// Standard output as one JSON value a line.
    pub fn json_lines(&self) -> Vec<Value> {
        self.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }
}
