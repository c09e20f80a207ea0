use ::wgsl_cpu::runtime::{self as rt, Mat, Vec2, Vec3, Vec4};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    pub at: f32,
    pub which: u32,
}

impl rt::Zero for Found {
    const ZERO: Self = Self {
        at: rt::zero(),
        which: rt::zero(),
    };
}

pub const BINDINGS: &[rt::Binding] = &[
    rt::Binding { name: "tree", slot: 0, kind: rt::BindingKind::StorageRead, min_bytes: 16 },
    rt::Binding { name: "found", slot: 1, kind: rt::BindingKind::StorageReadWrite, min_bytes: 16 },
];

#[derive(Clone, Copy, Debug)]
pub struct Globals<'a> {
    pub tree: rt::Storage<'a>,
    pub found: rt::Storage<'a>,
}

impl<'a> Globals<'a> {
    /// # Safety
    /// As for `NativeEntry`, as long as the result is in use.
    pub unsafe fn new(bindings: &[rt::Storage<'a>]) -> Self {
        rt::check_bindings(BINDINGS, bindings);
        // SAFETY: the buffers are large enough for the uniforms.
        unsafe {
            Self {
                tree: bindings[0],
                found: bindings[1],
            }
        }
    }
}

#[inline]
pub fn weight(x: f32) -> f32 {
    crate::by_hand!(x)
}

#[inline]
pub fn search(globals: &Globals<'_>, origin: Vec3<f32>, reach: f32) -> Found {
    crate::by_hand!(globals, origin, reach)
}

#[inline(always)]
fn native(globals: &Globals<'_>, id: Vec3<u32>) {
    // SAFETY: `Globals::new`'s contract: the buffers hold what is accessed here, and every
    // index is kept in range.
    unsafe {
        let e2 = id.x as f32;
        let e5 = weight(3.0f32);
        let result = search(globals, Vec3::splat(e2), e5);
        globals.found.element(id.x, 0, 16).store(Vec4::new(result.at, result.which as f32, 0.0f32, 0.0f32));
    }
}

pub const WORKGROUP_SIZE: u32 = 64;
pub const WORKGROUP_OVERRIDE: Option<&str> = None;

/// # Safety
/// As for `NativeEntry`.
pub unsafe fn entry(bindings: &[rt::Storage<'_>], invocations: rt::Invocations) {
    // SAFETY: this function's own contract.
    let globals = unsafe { Globals::new(bindings) };
    invocations.for_each(WORKGROUP_SIZE, |invocation| native(&globals, invocation.global_invocation_id));
}
