//! The record of a kernel: its WGSL, its native twin, its bindings.

use super::{Storage, Vec3};

/// How a kernel sees one of its buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BindingKind {
    /// `var<uniform>`.
    Uniform,
    /// `var<storage, read>`.
    StorageRead,
    /// `var<storage, read_write>`.
    StorageReadWrite,
    /// `var t: texture_2d_array<u32>`: a texel store, see [`Storage::texel`].
    Texels,
}

impl BindingKind {
    /// Whether it is a storage buffer, of which adapters allow few.
    pub fn is_storage(self) -> bool {
        matches!(self, Self::StorageRead | Self::StorageReadWrite)
    }
}

/// One buffer of a kernel. All bindings are in group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Binding {
    /// The WGSL variable's name; buffers are bound by it.
    pub name: &'static str,
    /// The WGSL `@binding`.
    pub slot: u32,
    /// Its address space and access.
    pub kind: BindingKind,
    /// The least size in bytes the WGSL type asks for (one element of a runtime-sized array).
    pub min_bytes: u64,
}

/// Checks that the buffers are as many and as large as the bindings ask for.
///
/// # Panics
/// If they are not.
pub fn check_bindings(bindings: &[Binding], buffers: &[Storage<'_>]) {
    assert_eq!(bindings.len(), buffers.len(), "a kernel's buffers are as many as its bindings");
    for (binding, buffer) in bindings.iter().zip(buffers) {
        let (name, least, len) = (binding.name, binding.min_bytes, buffer.len_bytes());
        assert!(len as u64 >= least, "the buffer of `{name}` holds {len} bytes, not {least}");
    }
}

/// A part of a dispatch: the workgroups `first..first + count` in row-major order (x fastest) of
/// a grid of `grid` workgroups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Invocations {
    /// Index of the first workgroup.
    pub first: u32,
    /// How many workgroups to run.
    pub count: u32,
    /// The whole dispatch's size in workgroups, `num_workgroups` in WGSL.
    pub grid: [u32; 3],
}

/// WGSL's built-in values of one invocation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Invocation {
    /// Its place in the whole dispatch.
    pub global_invocation_id: Vec3<u32>,
    /// Its place in its workgroup.
    pub local_invocation_id: Vec3<u32>,
    /// The same as one number.
    pub local_invocation_index: u32,
    /// Its workgroup's place in the grid.
    pub workgroup_id: Vec3<u32>,
    /// The grid's size in workgroups.
    pub num_workgroups: Vec3<u32>,
}

impl Invocations {
    /// Calls `run` for each invocation of each workgroup in order, workgroups being
    /// `workgroup_size` invocations along x.
    #[inline(always)]
    pub fn for_each(self, workgroup_size: u32, mut run: impl FnMut(Invocation)) {
        let [width, height, _] = self.grid.map(|n| n.max(1));
        let num_workgroups = Vec3::from(self.grid);
        for group in (self.first..).take(self.count as usize) {
            let workgroup_id = Vec3::new(group % width, group / width % height, group / width / height);
            let first = workgroup_id.x * workgroup_size;
            for local in 0..workgroup_size {
                run(Invocation {
                    global_invocation_id: Vec3::new(first + local, workgroup_id.y, workgroup_id.z),
                    local_invocation_id: Vec3::new(local, 0, 0),
                    local_invocation_index: local,
                    workgroup_id,
                    num_workgroups,
                });
            }
        }
    }
}

/// The translated entry point: runs every invocation of the given workgroups. `bindings` are in
/// the order of [`Kernel::bindings`].
///
/// # Safety
///
/// Each [`Storage`] must be at least its binding's `min_bytes` long and no memory behind a
/// read-write binding may be accessed by anything but invocations of the same dispatch meanwhile.
pub type NativeEntry = unsafe fn(bindings: &[Storage<'_>], invocations: Invocations);

/// One kernel, runnable by any device.
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// The kernel's name, which is its file's and its entry point's.
    pub name: &'static str,
    /// The linked WGSL module.
    pub wgsl: &'static str,
    /// Its buffers, sorted by slot.
    pub bindings: &'static [Binding],
    /// Invocations per workgroup (x only; y and z are 1): on a CPU always, on a GPU unless an override
    /// says how many.
    pub workgroup_size: u32,
    /// The name of that override.
    pub workgroup_override: Option<&'static str>,
    /// The same kernel translated to Rust.
    pub native: NativeEntry,
}
