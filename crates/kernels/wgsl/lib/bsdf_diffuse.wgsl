// Diffuse surfaces: ρ / π. Where the shading normal leans, the cosine of the light to ns counts, and
// what is cut off of its lobe by the surface comes back by the cosine to ng (lib/bsdf_leaning.wgsl).

/// Cosine lobes of wi about ns and about ng, on wo's side of the surface.
fn diffuse_lobes(frame: Frame, wo: vec3<f32>, wi: vec3<f32>, about_ns: f32, about_ng: f32) -> f32 {
    let cos_g = dot(frame.ng, wi);
    if (cos_g * dot(frame.ng, wo) <= 0.0) {
        return 0.0;
    }
    let cos_s = select(-1.0, 1.0, cos_g > 0.0) * dot(frame.ns, wi);
    return (about_ns * max(cos_s, 0.0) + about_ng * abs(cos_g)) * INV_PI;
}

/// The share of samples drawn about ng: what is cut off of the lobe about ns; on light paths all, as the
/// light's cosines are then given.
fn diffuse_share_about_ng(frame: Frame, mode: u32) -> f32 {
    return select(share_cut_off(dot(frame.ng, frame.ns)), 1.0, mode == TRANSPORT_IMPORTANCE);
}

fn diffuse_pdf(frame: Frame, wo: vec3<f32>, wi: vec3<f32>, mode: u32) -> f32 {
    let share = diffuse_share_about_ng(frame, mode);
    return diffuse_lobes(frame, wo, wi, 1.0 - share, share);
}

/// f times the light's cosine, and the densities of the light's direction on a camera path (pdf_fwd) and
/// of the camera's on a light path (pdf_rev).
fn diffuse_terms(material: Material, frame: Frame, to_camera: vec3<f32>, to_light: vec3<f32>) -> BsdfTerms {
    let lobes = diffuse_lobes(frame, to_camera, to_light, 1.0, share_cut_off(dot(frame.ng, frame.ns)));
    return BsdfTerms(material.reflectance * lobes, diffuse_pdf(frame, to_camera, to_light, TRANSPORT_RADIANCE),
        diffuse_pdf(frame, to_light, to_camera, TRANSPORT_IMPORTANCE));
}

fn sample_diffuse(material: Material, frame: Frame, wo: vec3<f32>, u: vec3<f32>, mode: u32) -> BsdfSample {
    let side = select(-1.0, 1.0, dot(frame.ng, wo) > 0.0);
    let n = side * select(frame.ns, frame.ng, u.z < diffuse_share_about_ng(frame, mode));
    let wi = frame_from_normal(n) * sample_cosine_hemisphere(u.xy);
    let pdf = diffuse_pdf(frame, wo, wi, mode);
    if (pdf <= 0.0) {
        return no_sample();
    }
    let radiance = mode == TRANSPORT_RADIANCE;
    let cut_off = share_cut_off(dot(frame.ng, frame.ns));
    let f = diffuse_lobes(frame, select(wi, wo, radiance), select(wo, wi, radiance), 1.0, cut_off)
        * adjoint_cosines(frame, wo, wi, mode);
    let pdf_rev = diffuse_pdf(frame, wi, wo, TRANSPORT_IMPORTANCE - mode);
    return BsdfSample(wi, pdf, pdf_rev, material.reflectance * (f / pdf), false, false);
}
