//! Clients that torment a server, while its memory is watched.

use std::time::{Duration, Instant};

use tokio::task::JoinSet;

use crate::{
    Outcome,
    client::{rest, torment},
    verdict::Report,
};

/// Parts of a soak. After each the server comes to rest in the same state, so that its memory is comparable: what
/// it holds in between goes by the scene, the film and the files under way.
const PARTS: u32 = 6;
/// How long it rests.
const REST: Duration = Duration::from_secs(2);

/// What a process has had of the processors, in seconds of 100 ticks (Linux).
pub fn processor_seconds(pid: &str) -> Outcome<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat"))?;
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |field: usize| fields.get(field).and_then(|f| f.parse::<f64>().ok()).ok_or("no times");
    Ok((ticks(11)? + ticks(12)?) / 100.0)
}

/// A line of numbers in KiB of what the system says of a process, in MiB.
fn mib(pid: &str, line: &str) -> Outcome<f64> {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status"))?;
    let kib = status.lines().find_map(|l| l.strip_prefix(line)).ok_or_else(|| format!("no {line}"))?;
    Ok(kib.trim().trim_end_matches(" kB").parse::<f64>()? / 1024.0)
}

/// # Errors
/// If there is no such process.
pub async fn soak(address: &str, time: Duration, clients: u32, pid: &str) -> Outcome<Report> {
    let start = Instant::now();
    let mut report = Report { clients, peak: mib(pid, "VmHWM:")?, ..Report::default() };
    for part in 0..PARTS {
        let mut tasks = JoinSet::new();
        for client in 1..=clients {
            tasks.spawn(torment(address.to_owned(), time / PARTS, part * clients + client, pid.to_owned()));
        }
        let mut seen = std::mem::take(&mut report.seen);
        while let Some(client) = tasks.join_next().await {
            seen = seen.and(client?);
        }
        report.seen = seen;
        let rested = rest(address, REST).await;
        match rested.and_then(|()| Ok((mib(pid, "VmRSS:")?, mib(pid, "VmHWM:")?))) {
            Ok((at_rest, peak)) => {
                report.at_rest.push(at_rest);
                report.peak = peak;
            }
            Err(error) => {
                report.seen.failures.push(format!("it does not come to rest: {error}"));
                break;
            }
        }
    }
    Ok(Report { seconds: start.elapsed().as_secs_f64(), ..report })
}

#[cfg(test)]
mod tests {
    use std::sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    };

    use midway_device::CpuDevice;
    use midway_import::Variants;
    use midway_render::RenderSettings;
    use midway_view::{Address, Server, Session, Start};

    use super::*;

    /// A server in this process, until it is stopped: its address, and how to stop it.
    fn server() -> (String, Arc<AtomicBool>) {
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/cornell-box.gltf");
        let session = Session::start(Start {
            device: Arc::new(CpuDevice::new(Some(1)).unwrap()),
            scene: midway_import::load(scene.as_ref()).unwrap().scene,
            name: "cornell-box.gltf".to_owned(),
            variants: Variants::default(),
            variant: None,
            settings: RenderSettings { width: 24, height: 24, ..RenderSettings::default() },
            hold: Duration::from_millis(33),
            reference: None,
        })
        .unwrap();
        let server = Server::listen(Address { ip: None, port: 0 }, session, false, |_| {}).unwrap();
        let address = server.urls()[0].trim_start_matches("http://").trim_end_matches('/').to_owned();
        let stop = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stop);
        std::thread::spawn(move || server.serve(move || asked.load(Ordering::Relaxed)).unwrap());
        (address, stop)
    }

    fn own_pid() -> String {
        std::process::id().to_string()
    }

    #[tokio::test]
    async fn a_server_is_soaked() {
        let (address, stop) = server();
        let report = soak(&address, Duration::from_secs(6), 3, &own_pid()).await.unwrap();
        stop.store(true, Ordering::Relaxed);
        // Memory and waits are those of a test's process on a busy machine: not judged here.
        let seen = &report.seen;
        assert!(seen.failures.is_empty() && seen.unanswered == 0, "{seen:?}");
        assert!(seen.frames > 10 && seen.nonsense > 3 && seen.requests > 100, "{seen:?}");
    }

    #[tokio::test]
    async fn a_server_that_goes_is_told() {
        let (address, stop) = server();
        let ends = async {
            tokio::time::sleep(Duration::from_secs(1)).await;
            stop.store(true, Ordering::Relaxed);
        };
        let pid = own_pid();
        let (report, ()) = tokio::join!(soak(&address, Duration::from_secs(20), 2, &pid), ends);
        let reasons = report.unwrap().reasons();
        assert!(reasons.iter().any(|why| why.contains("the server has gone")), "{reasons:?}");
    }
}
