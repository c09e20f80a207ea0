// Glass whose index of refraction differs by colour (KHR_materials_dispersion): red is the C line,
// 656.3 nm, green the d line, 587.6 nm, blue the F line, 486.1 nm.
//
// A subpath that arrives at such a surface goes on in one channel c, drawn by the shares p of its
// throughput β, which becomes β_c / p_c in c and 0 elsewhere: its mean is β. From there on, as wherever
// a subpath has one channel, the draw is certain, and c needs no room beside the throughput.
//
// Unbiased: channel c of a contribution is divided by the chances that its subpaths drew c, which are
// of each subpath alone; subpaths of different channels join to nothing. So each strategy's estimate of
// channel c is what it were if all indices were those of c, in expectation over the draws. The chances
// are in estimators, never in a MIS weight: that is made of the densities by the indices of c, at every
// vertex (before the first dispersing one no density depends on c), which all strategies find alike for
// a path in c. So weights sum to 1, for each channel's path on its own.

fn disperses(flags: u32) -> bool {
    return may_have(FEATURE_DISPERSION) && (flags & MATERIAL_DISPERSES) != 0u;
}

/// The channel of a throughput that has one; the brightest of others.
fn channel_of(throughput: vec3<f32>) -> u32 {
    let green_or_blue = select(1u, 2u, throughput.z > throughput.y);
    return select(0u, green_or_blue, throughput[green_or_blue] > throughput.x);
}

/// A throughput that keeps one channel, drawn by u in [0, 1).
fn keep_one_channel(throughput: vec3<f32>, u: f32) -> vec3<f32> {
    let sum = throughput.x + throughput.y + throughput.z;
    let place = u * sum;
    var channel = select(select(2u, 1u, place < throughput.x + throughput.y), 0u, place < throughput.x);
    if (throughput[channel] <= 0.0) { // place was rounded up, or all is 0
        channel = channel_of(throughput);
    }
    return vec3<f32>(select(0.0, sum, channel == 0u), select(0.0, sum, channel == 1u), select(0.0, sum, channel == 2u));
}

/// A channel's index, by green's and by how far blue's is above it.
fn channel_ior(ior: f32, spread: f32, channel: u32) -> f32 {
    return ior + spread * (f32(channel) - 1.0);
}
