//! Which files a render writes, and writing them.

use std::{
    panic::resume_unwind,
    path::{Path, PathBuf},
    thread::{self, ScopedJoinHandle},
};

use midway_film::{Channel, Display, Framing, Image, Metadata, check_writable, write_exr_with, write_png};

use crate::status::{Failure, Outcome, Status};

/// A format by its extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Exr,
    Png,
}

/// The files of a render and how to fill them.
#[derive(Debug)]
pub struct Outputs {
    files: Vec<(PathBuf, Format)>,
    display: Display,
}

impl Outputs {
    /// Decides the files: one `given` path is joined by the other format beside it, several are
    /// taken as they are, none stands for the scene's name in the current folder.
    ///
    /// # Errors
    /// [`Status::Usage`] for an extension other than `.exr` and `.png`, [`Status::Output`] if one
    /// of the files could not be written now.
    pub fn plan(given: &[PathBuf], scene: &Path, display: Display) -> Outcome<Self> {
        let stem = || PathBuf::from(scene.file_stem().unwrap_or("render".as_ref()));
        let files = match given {
            [] => both(&stem()),
            [one] => both(&without_extension(one)?),
            several => {
                several.iter().map(|path| Ok((path.clone(), format(path)?))).collect::<Outcome<_>>()?
            }
        };
        files.iter().try_for_each(|(path, _)| check_writable(path))?;
        Ok(Self { files, display })
    }

    /// The files, in the order in which they are written.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|(path, _)| path.as_path())
    }

    /// Whether one of the files can hold layers beside the picture.
    pub fn hold_layers(&self) -> bool {
        self.files.iter().any(|(_, format)| *format == Format::Exr)
    }

    /// Writes every file, all at once, an EXR with the `channels` beside the image; if one fails the
    /// others are still written.
    ///
    /// # Errors
    /// [`Status::Output`], naming each file that failed.
    pub fn write(
        &self,
        image: &Image,
        channels: &[Channel],
        framing: Option<Framing>,
        metadata: &Metadata,
    ) -> Outcome {
        let write = |(path, format): &(PathBuf, Format)| match format {
            Format::Exr => write_exr_with(path, image, channels, framing, metadata),
            Format::Png => write_png(path, image, self.display, metadata),
        };
        let outcomes: Vec<_> = thread::scope(|scope| {
            let writing: Vec<_> = self.files.iter().map(|file| scope.spawn(|| write(file))).collect();
            let finish =
                |file: ScopedJoinHandle<'_, _>| file.join().unwrap_or_else(|panic| resume_unwind(panic));
            writing.into_iter().map(finish).collect()
        });
        let errors: Vec<String> =
            outcomes.into_iter().filter_map(Result::err).map(|error| error.to_string()).collect();
        if errors.is_empty() { Ok(()) } else { Err(Failure::new(Status::Output, errors.join("; "))) }
    }
}

fn both(stem: &Path) -> Vec<(PathBuf, Format)> {
    let with = |extension: &str| {
        // Not `with_extension`: the stem of `a.b.gltf` is `a.b`, whose `.b` stays.
        let mut name = stem.as_os_str().to_owned();
        name.push(extension);
        PathBuf::from(name)
    };
    vec![(with(".exr"), Format::Exr), (with(".png"), Format::Png)]
}

fn without_extension(path: &Path) -> Outcome<PathBuf> {
    if path.extension().is_none() && path.file_name().is_some() {
        return Ok(path.to_owned());
    }
    format(path).map(|_| path.with_extension(""))
}

fn format(path: &Path) -> Outcome<Format> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("exr") => Ok(Format::Exr),
        Some("png") => Ok(Format::Png),
        _ => Err(Failure::usage(format!("{}: outputs end in .exr or .png", path.display()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(given: &[&Path], scene: &str) -> Outcome<Vec<PathBuf>> {
        let given: Vec<PathBuf> = given.iter().map(|path| path.to_path_buf()).collect();
        let outputs = Outputs::plan(&given, scene.as_ref(), Display::default())?;
        Ok(outputs.paths().map(Path::to_owned).collect())
    }

    #[test]
    fn one_name_makes_both_files() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for given in ["a.b.exr", "a.b.png", "a.b.PNG"] {
            assert_eq!(plan(&[&at(given)], "s.gltf").unwrap(), [at("a.b.exr"), at("a.b.png")]);
        }
        assert_eq!(plan(&[&at("a")], "s.gltf").unwrap(), [at("a.exr"), at("a.png")]);
        assert_eq!(plan(&[&at("x.png"), &at("y.png")], "s.gltf").unwrap(), [at("x.png"), at("y.png")]);
        assert_eq!(both(Path::new("my.scene")), plan_pair("my.scene.exr", "my.scene.png"));
    }

    fn plan_pair(exr: &str, png: &str) -> Vec<(PathBuf, Format)> {
        vec![(exr.into(), Format::Exr), (png.into(), Format::Png)]
    }

    #[test]
    fn other_extensions_and_missing_folders_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(plan(&[&folder.path().join("a.jpg")], "s").unwrap_err().status, Status::Usage);
        assert_eq!(plan(&[Path::new("..")], "s").unwrap_err().status, Status::Usage);
        assert_eq!(plan(&[&folder.path().join("none/a.exr")], "s").unwrap_err().status, Status::Output);
    }

    #[test]
    fn one_failure_does_not_stop_the_other_file() {
        let folder = tempfile::tempdir().unwrap();
        let gone = folder.path().join("gone");
        std::fs::create_dir(&gone).unwrap();
        let given = [gone.join("a.exr"), folder.path().join("a.png")];
        let outputs = Outputs::plan(&given, "s".as_ref(), Display::default()).unwrap();
        std::fs::remove_dir(&gone).unwrap();
        let image = Image::filled(2, 2, [0.5; 3]);
        let failure = outputs.write(&image, &[], None, &Metadata::new()).unwrap_err();
        assert_eq!(failure.status, Status::Output);
        assert!(failure.to_line().contains("a.exr"));
        assert!(given[1].exists());
    }
}
