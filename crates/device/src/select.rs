//! Choosing a device by the name that a user gave.

use std::{env, path::PathBuf, sync::Arc};

use crate::{
    CpuDevice, Device, DeviceError, DeviceInfo, DeviceKind, GpuDevice,
    gpu::adapter::{self, Found},
};

/// How to open a device.
#[derive(Clone, Debug, Default)]
pub struct OpenOptions {
    /// Threads of the CPU device; one for each core if none.
    pub threads: Option<usize>,
    /// Where GPU drivers' compiled kernels are kept between starts; the platform's folder for
    /// caches if none.
    pub cache_folder: Option<PathBuf>,
}

/// All devices of this machine: real GPUs, in the order in which `auto` prefers them, the CPU, and
/// software GPUs.
pub fn list_devices() -> Vec<DeviceInfo> {
    list(&adapter::enumerate())
}

/// Opens the device that `choice` means:
///
/// - `cpu`: this machine's cores; no GPU driver is touched;
/// - `gpu`: the best real GPU;
/// - `auto`: the best real GPU, or the CPU where there is none;
/// - a name: the one GPU, or software GPU, whose name is or contains it, in any case of letters.
///
/// [`Device::info`] says which it became.
///
/// # Errors
/// [`DeviceError::UnknownDevice`], [`DeviceError::AmbiguousDevice`] or [`DeviceError::NoGpu`] say
/// what there is; [`DeviceError::OpenFailed`] what the driver said.
pub fn open_device(choice: &str, options: &OpenOptions) -> Result<Arc<dyn Device>, DeviceError> {
    if choice.eq_ignore_ascii_case("cpu") {
        return open_cpu(options);
    }
    let mut found = adapter::enumerate();
    let index = match choice.to_ascii_lowercase().as_str() {
        wanted @ ("auto" | "gpu") => match found.iter().position(is_real) {
            Some(index) => index,
            None if wanted == "auto" => return open_cpu(options),
            None => return Err(DeviceError::NoGpu { available: names(&list(&found)) }),
        },
        _ => by_name(choice, &names_of(&found), || names(&list(&found)))?,
    };
    Ok(Arc::new(GpuDevice::open(found.swap_remove(index), options.cache_folder.as_deref())?))
}

/// Opens several devices for one job, each once: `all` means every real GPU, and names as
/// [`open_device`] takes them may be given with commas between them.
///
/// # Errors
/// As [`open_device`]; [`DeviceError::GivenTwice`] where two names mean one device.
pub fn open_devices(choice: &str, options: &OpenOptions) -> Result<Vec<Arc<dyn Device>>, DeviceError> {
    if choice.eq_ignore_ascii_case("all") {
        let real: Vec<_> = adapter::enumerate().into_iter().filter(is_real).collect();
        if real.is_empty() {
            return Err(DeviceError::NoGpu { available: names(&list_devices()) });
        }
        let open = |found| Ok(Arc::new(GpuDevice::open(found, options.cache_folder.as_deref())?) as Arc<_>);
        return real.into_iter().map(open).collect();
    }
    let mut opened: Vec<Arc<dyn Device>> = Vec::new();
    for name in choice.split(',') {
        let device = open_device(name.trim(), options)?;
        if opened.iter().any(|other| other.info().name == device.info().name) {
            return Err(DeviceError::GivenTwice { device: device.info().name.clone() });
        }
        opened.push(device);
    }
    Ok(opened)
}

/// Keeps Mesa's Vulkan layer from telling the terminal of a desktop that is not there. For a
/// program's first line; what the user has set stays.
///
/// # Safety
/// No other thread of the process runs yet: the environment is written.
pub unsafe fn keep_drivers_quiet() {
    let set = |variable| env::var_os(variable).is_some();
    if cfg!(target_os = "linux") && !set("XDG_RUNTIME_DIR") && !set("NODEVICE_SELECT") {
        // SAFETY: this function's contract.
        unsafe { env::set_var("NODEVICE_SELECT", "1") };
    }
}

fn open_cpu(options: &OpenOptions) -> Result<Arc<dyn Device>, DeviceError> {
    Ok(Arc::new(CpuDevice::new(options.threads)?))
}

fn is_real(found: &Found) -> bool {
    found.info.kind == DeviceKind::Gpu
}

fn list(found: &[Found]) -> Vec<DeviceInfo> {
    let infos =
        |real| found.iter().filter(move |found| is_real(found) == real).map(|found| found.info.clone());
    infos(true).chain([CpuDevice::describe(None)]).chain(infos(false)).collect()
}

fn names(infos: &[DeviceInfo]) -> Vec<String> {
    infos.iter().map(|info| info.name.clone()).collect()
}

fn names_of(found: &[Found]) -> Vec<&str> {
    found.iter().map(|found| found.info.name.as_str()).collect()
}

/// The index of the one name that is, or contains, what was asked for.
fn by_name(
    asked: &str,
    names: &[&str],
    available: impl FnOnce() -> Vec<String>,
) -> Result<usize, DeviceError> {
    let wanted = asked.trim().to_lowercase();
    if let Some(exact) = names.iter().position(|name| name.to_lowercase() == wanted) {
        return Ok(exact);
    }
    let contains = |name: &str| !wanted.is_empty() && name.to_lowercase().contains(&wanted);
    let matches: Vec<usize> = (0..names.len()).filter(|&index| contains(names[index])).collect();
    match matches[..] {
        [one] => Ok(one),
        [] => Err(DeviceError::UnknownDevice { asked: asked.into(), available: available() }),
        _ => Err(DeviceError::AmbiguousDevice {
            asked: asked.into(),
            matches: matches.into_iter().map(|index| names[index].to_owned()).collect(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::by_name;
    use crate::DeviceError;

    const NAMES: [&str; 4] =
        ["NVIDIA RTX 4090", "NVIDIA RTX 4090 #2", "AMD Radeon 780M", "llvmpipe (LLVM 15.0.6, 256 bits)"];

    fn find(asked: &str) -> Result<usize, DeviceError> {
        by_name(asked, &NAMES, || vec!["cpu".into()])
    }

    #[test]
    fn a_part_of_one_name_is_enough() {
        assert_eq!(find("radeon"), Ok(2));
        assert_eq!(find("LLVMpipe"), Ok(3));
        assert_eq!(find("#2"), Ok(1));
    }

    #[test]
    fn the_whole_name_wins_over_a_part() {
        assert_eq!(find("nvidia rtx 4090"), Ok(0));
    }

    #[test]
    fn a_part_of_several_names_lists_them() {
        let matches = NAMES[..2].iter().map(|&name| name.to_owned()).collect();
        assert_eq!(find("rtx"), Err(DeviceError::AmbiguousDevice { asked: "rtx".into(), matches }));
    }

    #[test]
    fn no_name_lists_what_there_is() {
        for asked in ["voodoo", "", "  "] {
            let error = DeviceError::UnknownDevice { asked: asked.into(), available: vec!["cpu".into()] };
            assert_eq!(find(asked), Err(error));
        }
    }
}
