//! A running render shown elsewhere: in tev, or on the viewer's page.

use std::{
    net::{TcpStream, ToSocketAddrs},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::JoinHandle,
    time::{Duration, Instant},
};

use midway_device::DeviceInfo;
use midway_film::{Display, Image};
use midway_scene::Scene;
use midway_view::{Address, Publisher, Server, ViewError};
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use super::{frame::Frame, job::RenderJob, schedule::State};
use crate::{
    console,
    status::{Failure, OrStatus, Outcome, Status},
};

/// tev is sent a picture no more often.
const EVERY: Duration = Duration::from_millis(500);
/// It has to answer, and to take what it is sent, within this.
const PATIENCE: Duration = Duration::from_secs(5);
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A picture in tev.
pub struct Tev {
    client: TevClient,
    name: String,
    last: Option<Instant>,
}

impl Tev {
    /// Connects and makes a picture of the frame's size.
    ///
    /// # Errors
    /// [`Status::Output`] if nobody listens there.
    pub fn connect(address: &str, name: &str, frame: &Frame) -> Outcome<Self> {
        let refused = |error: &dyn std::fmt::Display| {
            Failure::new(Status::Output, format!("--display {address}: {error}"))
        };
        let mut found = address.to_socket_addrs().map_err(|error| refused(&error))?;
        let place = found.next().ok_or_else(|| refused(&"no such host"))?;
        let stream = TcpStream::connect_timeout(&place, PATIENCE).map_err(|error| refused(&error))?;
        stream.set_write_timeout(Some(PATIENCE)).map_err(|error| refused(&error))?;
        let mut client = TevClient::wrap(stream);
        let [width, height] = frame.image_size().map(|side| side as u32);
        let create =
            PacketCreateImage { image_name: name, grab_focus: true, width, height, channel_names: &CHANNELS };
        client.send(create).map_err(|error| refused(&error))?;
        Ok(Self { client, name: name.to_owned(), last: None })
    }

    /// Whether it is time for another picture.
    pub fn is_due(&self) -> bool {
        self.last.is_none_or(|last| last.elapsed() >= EVERY)
    }

    /// Sends the picture so far.
    ///
    /// # Errors
    /// [`Status::Output`] if tev has gone.
    pub fn update(&mut self, image: &Image) -> Outcome {
        let data: Vec<f32> = image.pixels.iter().flatten().copied().collect();
        let update = PacketUpdateImage {
            image_name: &self.name,
            grab_focus: false,
            channel_names: &CHANNELS,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3, 3, 3],
            x: 0,
            y: 0,
            width: image.width as u32,
            height: image.height as u32,
            data: &data,
        };
        self.last = Some(Instant::now());
        self.client.send(update).or_status(Status::Output)
    }
}

/// A render on the viewer's page, to be looked at.
pub struct Served {
    publisher: Publisher,
    stop: Arc<AtomicBool>,
    server: Option<JoinHandle<Result<(), ViewError>>>,
}

impl Served {
    /// Serves the page at a port of loopback.
    ///
    /// # Errors
    /// [`Status::Usage`] if the port is taken.
    pub fn start(port: u16, scene: &Scene, name: &str, frame: &Frame, display: Display) -> Outcome<Self> {
        let publisher = Publisher::start(scene, name, &frame.camera, display).or_status(Status::Internal)?;
        let address = Address { ip: None, port };
        let server =
            Server::listen(address, publisher.session(), true, console::note).or_status(Status::Usage)?;
        console::note(&format!("view: {}", server.urls().join(" or ")));
        let stop = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stop);
        let thread = std::thread::spawn(move || server.serve(move || asked.load(Ordering::Relaxed)));
        Ok(Self { publisher, stop, server: Some(thread) })
    }

    /// Shows how the render stands.
    ///
    /// # Errors
    /// [`Status::Device`] if the device fails.
    pub fn publish(&mut self, job: &mut RenderJob, state: &State, info: &DeviceInfo) -> Outcome {
        let stats = *job.stats();
        self.publisher.publish(job.renderer()?, &stats, state.seconds(), info).or_status(Status::Device)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // What the server came to no longer matters to the render.
        let _ = self.server.take().map(JoinHandle::join);
    }
}

/// Where a running render is shown besides its files.
#[derive(Default)]
pub struct Live {
    /// In tev.
    pub tev: Option<Tev>,
    /// On the viewer's page.
    pub served: Option<Served>,
}

impl Live {
    /// After a pass. tev that has gone is told once and left.
    ///
    /// # Errors
    /// Of the device.
    pub fn after_pass(
        &mut self,
        job: &mut RenderJob,
        state: &State,
        info: &DeviceInfo,
        is_last: bool,
    ) -> Outcome {
        use super::schedule::Job;
        if let Some(tev) = self.tev.as_mut().filter(|tev| is_last || tev.is_due())
            && let Err(failure) = tev.update(&job.image()?)
        {
            console::warning(&format!("tev: {}", failure.to_line()));
            self.tev = None;
        }
        self.served.as_mut().map_or(Ok(()), |served| served.publish(job, state, info))
    }
}
