//! Which camera, how many pixels, which part of them.

use glam::Vec3;
use midway_film::Framing;
use midway_scene::{Camera, Projection, Scene};

use crate::{
    args::{CropArg, RenderArgs, Vec3Arg},
    status::{Failure, Outcome},
};

/// Height where neither flag nor camera says.
const DEFAULT_HEIGHT: u32 = 512;
/// Of a camera placed by flags.
const DEFAULT_FOV_DEGREES: f32 = 40.0;
/// Longest side.
const MAX_SIDE: f32 = 65_535.0;

/// What is looked through, and at which pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The camera.
    pub camera: Camera,
    /// Pixels across the whole frame.
    pub width: u32,
    /// Pixels down the whole frame.
    pub height: u32,
    /// The part that is rendered, if not all; inside the frame.
    pub crop: Option<CropArg>,
}

impl Frame {
    /// Follows the flags and, where they are silent, the scene.
    ///
    /// # Errors
    /// [`crate::status::Status::Usage`] for a camera that is not there and a crop that reaches out
    /// of the frame.
    pub fn resolve(args: &RenderArgs, scene: &Scene) -> Outcome<Self> {
        let mut camera = camera(args, scene)?;
        if let Some(degrees) = args.fov {
            if degrees >= 180.0 {
                return Err(Failure::usage("--fov: the field of view must be below 180 degrees"));
            }
            camera.projection = Projection::Perspective { yfov: degrees.to_radians() };
        }
        if let Some(height) = args.ortho {
            camera.projection = Projection::Orthographic { height };
        }
        camera.lens_radius = args.lens_radius.unwrap_or(camera.lens_radius);
        if args.focus_distance.is_some() && camera.lens_radius == 0.0 {
            return Err(Failure::usage("--focus-distance works with a lens only: add --lens-radius"));
        }
        camera.focus_distance = args.focus_distance.unwrap_or(camera.focus_distance);
        let [width, height] = size(args, &camera);
        if let Some(crop) = args.crop {
            let reaches =
                |from: u32, length: u32, end: u32| u64::from(from) + u64::from(length) > u64::from(end);
            if reaches(crop.x, crop.width, width) || reaches(crop.y, crop.height, height) {
                return Err(Failure::usage(format!(
                    "--crop reaches out of the frame of {width}x{height} pixels"
                )));
            }
        }
        Ok(Self { camera, width, height, crop: args.crop })
    }

    /// Width and height of the image that is rendered.
    pub fn image_size(&self) -> [usize; 2] {
        self.crop
            .map_or([self.width, self.height], |crop| [crop.width, crop.height])
            .map(|side| side as usize)
    }

    /// For the EXR's windows; `None` for a whole frame.
    pub fn framing(&self) -> Option<Framing> {
        let pair = |x: u32, y: u32| [x as usize, y as usize];
        self.crop.map(|crop| Framing { frame: pair(self.width, self.height), offset: pair(crop.x, crop.y) })
    }
}

fn camera(args: &RenderArgs, scene: &Scene) -> Outcome<Camera> {
    if let (Some(eye), Some(target)) = (args.eye, args.target) {
        let up = args.up.unwrap_or(Vec3Arg([0.0, 1.0, 0.0]));
        let fov = DEFAULT_FOV_DEGREES.to_radians();
        let [eye, target, up] = [eye, target, up].map(|Vec3Arg(v)| Vec3::from_array(v));
        let camera =
            Camera::look_at(eye, target, up, fov).map_err(|e| Failure::usage(format!("--eye: {e}")))?;
        return Ok(Camera { focus_distance: eye.distance(target), ..camera });
    }
    if let Some(wanted) = &args.camera {
        return named(wanted, &scene.cameras).cloned();
    }
    Ok(scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds(), 1.0)))
}

fn named<'a>(wanted: &str, cameras: &'a [Camera]) -> Outcome<&'a Camera> {
    let by_name = cameras.iter().find(|camera| camera.name == wanted);
    let by_index = || wanted.parse::<usize>().ok().and_then(|index| cameras.get(index));
    by_name.or_else(by_index).ok_or_else(|| {
        let known: Vec<String> =
            cameras.iter().enumerate().map(|(index, camera)| format!("{index} '{}'", camera.name)).collect();
        let known = if known.is_empty() { "no camera".to_owned() } else { known.join(", ") };
        Failure::usage(format!("--camera: no camera '{wanted}'; the scene has {known}"))
    })
}

fn size(args: &RenderArgs, camera: &Camera) -> [u32; 2] {
    let side = |pixels: f32| pixels.round().clamp(1.0, MAX_SIDE) as u32;
    let of_film = |[width, height]: [u32; 2]| width as f32 / height as f32;
    let aspect = camera.resolution.map(of_film).or(camera.aspect).unwrap_or(1.0);
    match (args.width, args.height) {
        (Some(width), Some(height)) => [width, height],
        (Some(width), None) => [width, side(width as f32 / aspect)],
        (None, Some(height)) => [side(height as f32 * aspect), height],
        (None, None) => camera.resolution.unwrap_or([side(DEFAULT_HEIGHT as f32 * aspect), DEFAULT_HEIGHT]),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Command};

    fn args(flags: &[&str]) -> RenderArgs {
        let line = ["midway", "render", "s.gltf"].iter().chain(flags);
        let Command::Render(args) = Cli::try_parse_from(line).unwrap().command else { unreachable!() };
        *args
    }

    fn resolve(flags: &[&str], cameras: &[(&str, Option<f32>)]) -> Outcome<Frame> {
        let camera = |(name, aspect): &(&str, Option<f32>)| Camera {
            name: (*name).to_owned(),
            aspect: *aspect,
            ..Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0).unwrap()
        };
        let scene = Scene { cameras: cameras.iter().map(camera).collect(), ..Scene::default() };
        Frame::resolve(&args(flags), &scene)
    }

    #[test]
    fn sizes_follow_the_flags_then_the_camera() {
        let wide = [("main", Some(2.0))];
        let size = |flags: &[&str]| resolve(flags, &wide).map(|frame| [frame.width, frame.height]).unwrap();
        assert_eq!(size(&[]), [1024, 512]);
        assert_eq!(size(&["--width", "300"]), [300, 150]);
        assert_eq!(size(&["--height", "100"]), [200, 100]);
        assert_eq!(size(&["--width", "3", "--height", "5"]), [3, 5]);
        assert_eq!(resolve(&[], &[("main", None)]).unwrap().image_size(), [512, 512]);
    }

    #[test]
    fn a_cameras_own_resolution_is_the_default() {
        let scene = || {
            let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0).unwrap();
            let camera = Camera { aspect: Some(1.0), resolution: Some([640, 160]), ..camera };
            Scene { cameras: vec![camera], ..Scene::default() }
        };
        let size = |flags: &[&str]| {
            let frame = Frame::resolve(&args(flags), &scene()).unwrap();
            [frame.width, frame.height]
        };
        assert_eq!(size(&[]), [640, 160]);
        assert_eq!(size(&["--width", "100"]), [100, 25]);
        assert_eq!(size(&["--height", "100"]), [400, 100]);
        assert_eq!(size(&["--width", "3", "--height", "5"]), [3, 5]);
    }

    #[test]
    fn flags_change_projection_and_lens() {
        let one = [("m", None)];
        let camera = |flags: &[&str]| resolve(flags, &one).unwrap().camera;
        assert_eq!(camera(&["--ortho", "3"]).projection, Projection::Orthographic { height: 3.0 });
        let lens = camera(&["--lens-radius", "0.1", "--focus-distance", "4"]);
        assert_eq!((lens.lens_radius, lens.focus_distance), (0.1, 4.0));
        let placed = camera(&["--eye", "0,0,5", "--target", "0,0,2", "--lens-radius", "0.1"]);
        assert_eq!(placed.focus_distance, 3.0);
        assert!(resolve(&["--focus-distance", "4"], &one).is_err());
        assert!(resolve(&["--focus-distance", "4", "--lens-radius", "0"], &one).is_err());
    }

    #[test]
    fn cameras_go_by_name_then_index() {
        let two = [("a", None), ("0", None)];
        assert_eq!(resolve(&["--camera", "0"], &two).unwrap().camera.name, "0");
        assert_eq!(resolve(&["--camera", "1"], &two).unwrap().camera.name, "0");
        assert_eq!(resolve(&[], &two).unwrap().camera.name, "a");
        let missing = resolve(&["--camera", "b"], &two).unwrap_err().to_line();
        assert!(missing.contains("0 'a', 1 '0'"), "{missing}");
        assert!(resolve(&[], &[]).is_ok());
    }

    #[test]
    fn flags_place_a_camera() {
        let flags = ["--eye", "0,0,-5", "--target", "0,0,0", "--fov", "90"];
        let frame = resolve(&flags, &[]).unwrap();
        assert_eq!(frame.camera.position(), Vec3::new(0.0, 0.0, -5.0));
        assert!((frame.camera.yfov().unwrap().to_degrees() - 90.0).abs() <= 1e-4);
        assert!(resolve(&["--eye", "1,1,1", "--target", "1,1,1"], &[]).is_err());
        assert!(resolve(&["--fov", "180"], &[]).is_err());
    }

    #[test]
    fn a_crop_lies_in_the_frame() {
        let frame = resolve(&["--crop", "500,0,12,7"], &[("m", None)]).unwrap();
        assert_eq!(frame.image_size(), [12, 7]);
        assert_eq!(frame.framing(), Some(Framing { frame: [512, 512], offset: [500, 0] }));
        assert!(resolve(&["--crop", "500,0,13,7"], &[("m", None)]).is_err());
        assert!(resolve(&["--crop", "4294967295,0,4294967295,7"], &[("m", None)]).is_err());
    }
}
