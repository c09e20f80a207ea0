use ::wgsl_cpu::runtime::{self as rt, Mat, Vec2, Vec3, Vec4};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    pub count: u32,
    pub scale: Vec3<f32>,
    pub weights: [Vec4<f32>; 2],
}

impl rt::Zero for Params {
    const ZERO: Self = Self {
        count: rt::zero(),
        scale: rt::zero(),
        weights: rt::zero(),
    };
}

impl rt::Stored for Params {
    const SIZE: usize = 64;
    const ALIGN: usize = 16;
    #[inline(always)]
    unsafe fn load(bytes: *const u8) -> Self {
        // SAFETY: the members lie inside the struct, whose place is valid by contract.
        unsafe {
            Self {
                count: rt::Stored::load(bytes.add(0)),
                scale: rt::Stored::load(bytes.add(16)),
                weights: rt::Stored::load(bytes.add(32)),
            }
        }
    }
    #[inline(always)]
    unsafe fn store(self, bytes: *mut u8) {
        // SAFETY: as for loading.
        unsafe {
            self.count.store(bytes.add(0));
            self.scale.store(bytes.add(16));
            self.weights.store(bytes.add(32));
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    pub position: Vec3<f32>,
    pub kind: u32,
    pub samples: [f32; 5],
}

impl rt::Zero for Item {
    const ZERO: Self = Self {
        position: rt::zero(),
        kind: rt::zero(),
        samples: rt::zero(),
    };
}

impl rt::Stored for Item {
    const SIZE: usize = 48;
    const ALIGN: usize = 16;
    #[inline(always)]
    unsafe fn load(bytes: *const u8) -> Self {
        // SAFETY: the members lie inside the struct, whose place is valid by contract.
        unsafe {
            Self {
                position: rt::Stored::load(bytes.add(0)),
                kind: rt::Stored::load(bytes.add(12)),
                samples: rt::Stored::load(bytes.add(16)),
            }
        }
    }
    #[inline(always)]
    unsafe fn store(self, bytes: *mut u8) {
        // SAFETY: as for loading.
        unsafe {
            self.position.store(bytes.add(0));
            self.kind.store(bytes.add(12));
            self.samples.store(bytes.add(16));
        }
    }
}

pub const BINDINGS: &[rt::Binding] = &[
    rt::Binding { name: "params", slot: 0, kind: rt::BindingKind::Uniform, min_bytes: 64 },
    rt::Binding { name: "points", slot: 1, kind: rt::BindingKind::StorageRead, min_bytes: 16 },
    rt::Binding { name: "queue", slot: 3, kind: rt::BindingKind::StorageReadWrite, min_bytes: 64 },
    rt::Binding { name: "texels", slot: 4, kind: rt::BindingKind::Texels, min_bytes: 16 },
];

#[derive(Clone, Copy, Debug)]
pub struct Globals<'a> {
    pub params: Params,
    pub points: rt::Storage<'a>,
    pub queue: rt::Storage<'a>,
    pub texels: rt::Storage<'a>,
}

impl<'a> Globals<'a> {
    /// # Safety
    /// As for `NativeEntry`, as long as the result is in use.
    pub unsafe fn new(bindings: &[rt::Storage<'a>]) -> Self {
        rt::check_bindings(BINDINGS, bindings);
        // SAFETY: the buffers are large enough for the uniforms.
        unsafe {
            Self {
                params: bindings[0].at(0).load(),
                points: bindings[1],
                queue: bindings[2],
                texels: bindings[3],
            }
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Private {
    pub state: u32,
}

impl Private {
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            state: 1u32,
        }
    }
}

#[inline(always)]
pub fn texel(globals: &Globals<'_>, at: u32) -> Vec4<u32> {
    // SAFETY: `Globals::new`'s contract: the buffers hold what is accessed here, and every
    // index is kept in range.
    unsafe {
        globals.texels.texel(Vec2::new(at & 4095u32, at.wrapping_shr(12u32)), 0i32)
    }
}

#[inline(always)]
pub fn random(private: &mut Private) -> u32 {
    private.state = private.state.wrapping_mul(747796405u32).wrapping_add(2891336453u32);
    private.state
}

#[inline(always)]
pub fn push(globals: &Globals<'_>, item: Item) {
    // SAFETY: `Globals::new`'s contract: the buffers hold what is accessed here, and every
    // index is kept in range.
    unsafe {
        let at = globals.queue.at(0).atomic::<u32>().fetch_add(1u32);
        if at < globals.queue.array_length(16, 48) {
            globals.queue.element(at, 16, 48).store(item);
        }
        globals.queue.at(4).atomic::<i32>().fetch_max(at as i32);
    }
}

#[inline]
fn kernel(globals: &Globals<'_>, private: &mut Private, id: Vec3<u32>, lane: u32) {
    // SAFETY: `Globals::new`'s contract: the buffers hold what is accessed here, and every
    // index is kept in range.
    unsafe {
        let mut item: Item = rt::zero();
        if id.x >= globals.params.count {
            return;
        }
        private.state = private.state ^ id.x;
        let e19 = globals.points.element(id.x, 0, 16).load::<Vec4<f32>>();
        let e27 = globals.params.weights[rt::index(lane % 2u32, 2)];
        item.position = (globals.params.scale * Vec3::new(e19.x, e19.y, e19.z)) + Vec3::new(e27.x, e27.y, e27.z);
        let e31 = random(private);
        item.samples[rt::index(e31 % 5u32, 5)] = globals.points.element(2u32.wrapping_mul(id.x).wrapping_add(1u32), 0, 16).at(12).load::<f32>();
        globals.queue.element(id.x, 16, 48).at(4).store(item.samples[2]);
        let e55 = texel(globals, id.x);
        item.kind = e55.w;
        push(globals, item);
    }
}

pub const WORKGROUP_SIZE: u32 = 64;
pub const WORKGROUP_OVERRIDE: Option<&str> = None;

/// # Safety
/// As for `NativeEntry`.
pub unsafe fn entry(bindings: &[rt::Storage<'_>], invocations: rt::Invocations) {
    // SAFETY: this function's own contract.
    let globals = unsafe { Globals::new(bindings) };
    invocations.for_each(WORKGROUP_SIZE, |invocation| kernel(&globals, &mut Private::new(), invocation.global_invocation_id, invocation.local_invocation_index));
}
