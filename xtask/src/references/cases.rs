//! Which scenes have a picture by someone else, and how near ours is to come.

/// A scene with the picture that another renderer made of it.
pub struct Case {
    /// For the table and `--only`.
    pub name: &'static str,
    /// The scene.
    pub file: File,
    /// The picture, EXR, relative to the folder of scenes.
    pub reference: &'static str,
    /// Edges of the longest path in the picture; none: all paths.
    pub longest: Option<u32>,
    /// How far from 1 the median of the blocks' ratios may be, or why nothing is claimed.
    pub claim: Result<f64, &'static str>,
}

/// Where a scene is.
pub enum File {
    /// A file relative to the folder of scenes.
    At(&'static str),
    /// The same, its metals put back to the indices and the single bounces of the picture.
    WithMetals(&'static str, Metal),
    /// One of Ignis' evaluation for Mitsuba.
    Ignis(&'static str),
    /// [`IGNIS_BOX`].
    IgnisBox,
}

/// A measured metal. glTF has only Schlick's approximation from the reflectance at normal
/// incidence, and towards grazing angles that is far above what a metal or a dark one reflects.
pub struct Metal {
    /// η of R, G and B.
    pub eta: [f32; 3],
    /// k of R, G and B.
    pub k: [f32; 3],
}

/// Aluminium, as every metal of Veach's door is in Mitsuba's file of it.
const ALUMINIUM: Metal = Metal { eta: [1.65746, 0.880369, 0.521229], k: [9.22387, 6.26952, 4.837] };

/// Ignis' evaluation. Its scenes for Mitsuba were written to lie one folder higher: `meshes` is
/// `evaluation/meshes`, and `../meshes` the folder beside it, which has others of the same names.
pub const IGNIS: &str = "references/ignis-evaluation";
/// The Cornell box of Ignis' evaluation, of which it has no file for Mitsuba.
pub const IGNIS_BOX: &str = include_str!("cbox.xml");

/// Why a picture with a medium is at another path length than ours can be.
const BOUNDARIES: &str = "none: boundaries of media are vertices of ours, not of Mitsuba's";

/// A scene of Bitterli's, converted to glTF.
macro_rules! bitterli {
    ($name:literal, $longest:expr, $tolerance:literal $(, $metal:expr)?) => {
        Case {
            name: $name,
            file: bitterli!(@file concat!("transport/", $name, "/", $name, ".gltf") $(, $metal)?),
            reference: concat!("transport/", $name, "/reference.exr"),
            longest: $longest,
            claim: Ok($tolerance),
        }
    };
    (@file $path:expr) => { File::At($path) };
    (@file $path:expr, $metal:expr) => { File::WithMetals($path, $metal) };
}

/// A scene of Ignis' evaluation that Mitsuba has rendered.
macro_rules! ignis {
    ($name:literal, $file:expr, $longest:literal) => {
        ignis!($name, $file, $longest, Ok(0.01))
    };
    ($name:literal, $file:expr, $longest:literal, $claim:expr) => {
        Case {
            name: concat!("ignis/", $name),
            file: $file,
            reference: concat!("references/ignis-evaluation/evaluation/references/ref-", $name, "-4096.exr"),
            longest: Some($longest),
            claim: $claim,
        }
    };
}

/// All of them. Mitsuba's `max_depth` is the number of edges.
pub const CASES: [Case; 14] = [
    bitterli!("cornell-box", None, 0.005),
    bitterli!("veach-mis", Some(2), 0.02),
    bitterli!("veach-ajar", Some(12), 0.02, ALUMINIUM),
    ignis!("room", File::Ignis("room"), 4),
    ignis!("plane-d1", File::Ignis("plane"), 1),
    ignis!("plane-d6", File::Ignis("plane"), 6),
    ignis!("point", File::Ignis("point"), 4),
    ignis!("emissive-plane", File::Ignis("emissive-plane"), 4),
    ignis!("emissive-plane-scale", File::Ignis("emissive-plane-scale"), 4),
    ignis!("sphere-light", File::Ignis("sphere-light"), 4),
    ignis!("multilight", File::Ignis("multilight"), 4),
    ignis!("volume", File::Ignis("volume"), 12, Err(BOUNDARIES)),
    ignis!("cbox-d1", File::IgnisBox, 1),
    ignis!("cbox-d6", File::IgnisBox, 6),
];
