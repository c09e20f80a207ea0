//! What a render will allocate, known and checked before it is taken.

use std::fmt;

use crate::{Bytes, DeviceError, DeviceInfo};

/// How many of the largest items an error names.
const NAMED_ITEMS: usize = 3;

/// One buffer of a plan.
#[derive(Clone, Debug)]
struct Item {
    label: String,
    bytes: u64,
    /// Whether it shrinks with the batch.
    scales: bool,
    /// Whether it is bound as a buffer, whose size adapters limit.
    binds: bool,
}

/// A list of the buffers that a render will take.
///
/// ```
/// use midway_device::MemoryPlan;
/// let mut plan = MemoryPlan::default();
/// plan.fixed("triangles", 48_000_000);
/// plan.scaling("camera paths", 64 << 20);
/// assert_eq!(plan.total(), 48_000_000 + (64 << 20));
/// println!("{plan}");
/// ```
#[derive(Clone, Debug, Default)]
pub struct MemoryPlan {
    items: Vec<Item>,
}

impl MemoryPlan {
    /// Adds a buffer whose size the scene and the film fix.
    pub fn fixed(&mut self, label: impl Into<String>, bytes: u64) {
        self.items.push(Item { label: label.into(), bytes, scales: false, binds: true });
    }

    /// Adds a buffer whose size is in proportion to the batch of paths in flight.
    pub fn scaling(&mut self, label: impl Into<String>, bytes: u64) {
        self.items.push(Item { label: label.into(), bytes, scales: true, binds: true });
    }

    /// Adds a texel store: its size is fixed, and may be above what a binding may be.
    pub fn texels(&mut self, label: impl Into<String>, bytes: u64) {
        self.items.push(Item { label: label.into(), bytes, scales: false, binds: false });
    }

    /// The labels and sizes in bytes, in the order they were added.
    pub fn items(&self) -> impl Iterator<Item = (&str, u64)> {
        self.items.iter().map(|item| (item.label.as_str(), item.bytes))
    }

    /// All bytes together.
    pub fn total(&self) -> u64 {
        self.items.iter().fold(0, |total, item| total.saturating_add(item.bytes))
    }

    /// The part of a batch, at most 1, whose buffers fit a device with the fixed ones; 0 where the
    /// fixed ones alone do not fit.
    pub fn batch_fraction_that_fits(&self, info: &DeviceInfo) -> f64 {
        if self.items.iter().any(|item| item.binds && !item.scales && item.bytes > info.max_binding_bytes) {
            return 0.0;
        }
        let scaling = self.items.iter().filter(|item| item.scales);
        let largest = scaling.clone().map(|item| item.bytes).max().unwrap_or(0);
        let scaling = scaling.fold(0, |total: u64, item| total.saturating_add(item.bytes));
        let Some(left) = usable(info).checked_sub(self.total() - scaling) else { return 0.0 };
        let by_memory = if scaling == 0 { 1.0 } else { left as f64 / scaling as f64 };
        let by_binding = if largest == 0 { 1.0 } else { info.max_binding_bytes as f64 / largest as f64 };
        by_memory.min(by_binding).min(1.0)
    }

    /// Checks each buffer against the device's limits and their sum against its memory, where that
    /// is known: a sixteenth is left to the driver and the rest of the system.
    ///
    /// # Errors
    /// [`DeviceError::BufferTooLarge`] or [`DeviceError::PlanTooLarge`].
    pub fn check(&self, info: &DeviceInfo) -> Result<(), DeviceError> {
        if let Some(item) = self.items.iter().find(|item| item.binds && item.bytes > info.max_binding_bytes) {
            return Err(DeviceError::BufferTooLarge {
                device: info.name.clone(),
                label: item.label.clone(),
                bytes: item.bytes,
                limit: info.max_binding_bytes,
            });
        }
        let (total, usable) = (self.total(), usable(info));
        if total <= usable {
            return Ok(());
        }
        let fraction = self.batch_fraction_that_fits(info);
        let advice = if fraction >= 0.01 {
            format!("a batch of {:.0} % of this one would fit", (fraction * 100.0).floor())
        } else {
            format!("a device with {} would do", Bytes(total.saturating_add(total / 15)))
        };
        let device = info.name.clone();
        Err(DeviceError::PlanTooLarge { device, total, usable, largest: self.largest(), advice })
    }

    fn largest(&self) -> String {
        let mut items: Vec<&Item> = self.items.iter().collect();
        items.sort_by_key(|item| std::cmp::Reverse(item.bytes));
        items.truncate(NAMED_ITEMS);
        let named: Vec<String> =
            items.iter().map(|item| format!("{} {}", item.label, Bytes(item.bytes))).collect();
        named.join(", ")
    }
}

/// Bytes of the device's memory that a plan may take.
fn usable(info: &DeviceInfo) -> u64 {
    info.memory_bytes.map_or(u64::MAX, |memory| memory - memory / 16)
}

impl fmt::Display for MemoryPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.items.iter().map(|item| item.label.chars().count()).max().unwrap_or(0).max(5);
        for item in &self.items {
            writeln!(f, "{:width$}  {:>10}", item.label, Bytes(item.bytes))?;
        }
        write!(f, "{:width$}  {:>10}", "total", Bytes(self.total()))
    }
}

#[cfg(test)]
mod tests {
    use super::MemoryPlan;
    use crate::{DeviceError, DeviceInfo, DeviceKind};

    const GIB: u64 = 1 << 30;

    fn device(memory: Option<u64>, binding: u64) -> DeviceInfo {
        DeviceInfo {
            name: "test".into(),
            kind: DeviceKind::Gpu,
            backend: "none".into(),
            memory_bytes: memory,
            max_buffer_bytes: binding,
            max_binding_bytes: binding,
            max_storage_buffers: 8,
            wide_workgroup: 64,
        }
    }

    fn plan() -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        plan.fixed("triangles", GIB);
        plan.scaling("camera paths", 2 * GIB);
        plan.scaling("light paths", GIB);
        plan
    }

    #[test]
    fn a_plan_that_fits_passes() {
        assert_eq!(plan().check(&device(Some(16 * GIB), 4 * GIB)), Ok(()));
        assert_eq!(plan().check(&device(None, 4 * GIB)), Ok(()));
        assert_eq!(MemoryPlan::default().check(&device(Some(0), 0)), Ok(()));
    }

    #[test]
    fn a_plan_over_the_memory_says_what_would_fit() {
        let small = device(Some(2 * GIB), 4 * GIB);
        let error = plan().check(&small).unwrap_err().to_string();
        assert_eq!(
            error,
            "4.0 GiB are needed and device 'test' has 1.9 GiB to give (largest: camera paths 2.0 GiB, \
             triangles 1.0 GiB, light paths 1.0 GiB); a batch of 29 % of this one would fit"
        );
        let tiny = device(Some(GIB / 2), 4 * GIB);
        let error = plan().check(&tiny).unwrap_err().to_string();
        assert!(error.ends_with("a device with 4.3 GiB would do"), "{error}");
    }

    #[test]
    fn a_buffer_over_the_binding_limit_is_named() {
        let error = plan().check(&device(None, GIB)).unwrap_err();
        assert!(
            matches!(&error, DeviceError::BufferTooLarge { label, limit: GIB, .. } if label == "camera paths"),
            "{error}"
        );
        assert_eq!(plan().batch_fraction_that_fits(&device(None, GIB)), 0.5);
    }

    #[test]
    fn a_plan_prints_a_table() {
        assert_eq!(
            plan().to_string(),
            "triangles        1.0 GiB\ncamera paths     2.0 GiB\nlight paths      1.0 GiB\n\
             total            4.0 GiB"
        );
    }
}
