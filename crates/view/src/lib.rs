//! The interactive viewer: a server on this machine whose page shows the picture as it converges, in a
//! browser on this machine or at the other end of a tunnel.
//!
//! Three threads and their rooms: the renderer's ([`worker`], [`engine`]; [`session`] is its other side), which
//! never waits for a browser, nor for what takes long ([`beside`], [`opening`], [`changing`]); the encoder's
//! ([`frame`]), where the newest picture wins; and the server's ([`server`], [`client`]). [`protocol`] is what is
//! said over the wire, [`guard`] who may say it.

mod beside;
mod black;
mod changing;
mod client;
mod engine;
mod frame;
mod guard;
mod layers;
mod measured;
mod names;
mod nothing;
mod opening;
mod pick;
mod protocol;
mod publish;
mod save;
mod server;
mod session;
mod told;
mod uploads;
mod worker;

use std::{io, net::SocketAddr};

pub use nothing::nothing;
pub use publish::Publisher;
pub use server::{Address, Server};
pub use session::{Session, Start};

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The renderer failed or refused.
    #[error(transparent)]
    Render(#[from] midway_render::RenderError),
    /// A file could not be written or read.
    #[error(transparent)]
    Film(#[from] midway_film::FilmError),
    /// A request that is not carried out.
    #[error("{0}")]
    Refused(String),
    /// The address cannot be listened at.
    #[error("cannot listen at {address}: {source}")]
    Listen {
        /// Where.
        address: SocketAddr,
        /// Why not.
        source: io::Error,
    },
    /// The system refused something else.
    #[error(transparent)]
    Io(#[from] io::Error),
}
