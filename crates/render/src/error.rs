//! What can go wrong in a render.

use midway_accel::AccelError;
use midway_device::DeviceError;
use midway_scene::SceneError;

/// What can go wrong in a render.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The settings contradict each other or the scene.
    #[error("{0}")]
    Settings(String),
    /// The scene is not valid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No acceleration structure could be built.
    #[error(transparent)]
    Accel(#[from] AccelError),
    /// The device failed or is too small.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A light path has more vertices than any store was planned for.
    #[error("one light path has over {capacity} vertices; set --max-path-length, or use --join k-step")]
    PathTooLong {
        /// Vertices that there was room for.
        capacity: u32,
    },
    /// The images are larger than the texel store can address.
    #[error("the scene's images take over 64 GiB of memory: scale them down")]
    TooManyTexels,
}
