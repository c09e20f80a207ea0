//! Infinite lights: their images by latitude and longitude, and how they are turned.
//!
//! pbrt has z up in an infinite light, and either of two layouts: v3's latitude and longitude, and
//! v4's equal-area octahedral map (P. Clarberg, "Fast Equal-Area Mapping of the (Hemi)Sphere using
//! SIMD", Journal of Graphics Tools 13(3), 2008).

use std::f64::consts::{FRAC_2_PI, PI, TAU};

use glam::{DMat3, DMat4, DVec3, Mat3};
use midway_scene::{Image, Texels};

/// How an image lies on the sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// Rows by the angle from +z, columns by the angle from +x towards +y.
    LatLong,
    /// Square, of equal areas.
    Octahedral,
}

/// The environment's frame from the light's, a quarter turn about x, with a mirror where the light's
/// transform has one: so that what is left of that is a rotation.
fn environment_from_light(mirrored: bool) -> DMat3 {
    let y = if mirrored { DVec3::Z } else { DVec3::NEG_Z };
    DMat3::from_cols(DVec3::X, y, DVec3::Y)
}

/// The rotation of the environment in the world, by the transform of its light; none where that has
/// no three axes.
pub(super) fn rotation(world_from_light: DMat4) -> Option<Mat3> {
    let m = DMat3::from_mat4(world_from_light);
    let mirrored = m.determinant() < 0.0;
    let z = m.z_axis.try_normalize()?;
    let x = m.y_axis.cross(z).try_normalize()?;
    let y = z.cross(x);
    let rigid = DMat3::from_cols(if mirrored { -x } else { x }, y, z);
    Some((rigid * environment_from_light(mirrored).transpose()).as_mat3())
}

/// The image by latitude and longitude as the scene has it: +y at the top, -z in the middle column,
/// u towards +x.
pub(super) fn resampled(image: &Image, layout: Layout, mirrored: bool) -> Image {
    let (width, height) = match layout {
        Layout::LatLong => (image.width, image.height),
        // As many rows as the octahedral map has: twice its texels.
        Layout::Octahedral => (image.width.saturating_mul(2), image.height),
    };
    let light_from_environment = environment_from_light(mirrored).transpose();
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    for row in 0..height {
        let (sin_theta, cos_theta) = (PI * (f64::from(row) + 0.5) / f64::from(height)).sin_cos();
        for column in 0..width {
            let (sin_phi, cos_phi) = (TAU * ((f64::from(column) + 0.5) / f64::from(width) - 0.5)).sin_cos();
            let d = DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
            texels.push(look_up(image, layout, light_from_environment * d));
        }
    }
    Image { name: image.name.clone(), width, height, texels: Texels::Float(texels.into()) }
}

/// What the upper hemisphere of an image, seen with weights of 1, comes to on a horizontal surface.
pub(super) fn illuminance(image: &Image, layout: Layout) -> f32 {
    // Rec. 709's luminance.
    const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];
    let (rows, columns) = (256, 512);
    let mut sum = 0.0;
    for row in 0..rows {
        // Equal steps in the square of cos θ are equal in cos θ dω.
        let cos_theta = ((f64::from(row) + 0.5) / f64::from(rows)).sqrt();
        let sin_theta = (1.0 - cos_theta * cos_theta).sqrt();
        for column in 0..columns {
            let (sin_phi, cos_phi) = (TAU * (f64::from(column) + 0.5) / f64::from(columns)).sin_cos();
            let d = DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta);
            let texel = look_up(image, layout, d);
            sum += LUMINANCE.iter().zip(texel).map(|(w, x)| w * f64::from(x)).sum::<f64>();
        }
    }
    (PI * sum / f64::from(rows * columns)) as f32
}

/// Between the four nearest texels.
fn look_up(image: &Image, layout: Layout, d: DVec3) -> [f32; 4] {
    let (u, v) = match layout {
        Layout::LatLong => {
            let phi = d.y.atan2(d.x).rem_euclid(TAU);
            (phi / TAU, d.z.clamp(-1.0, 1.0).acos() / PI)
        }
        Layout::Octahedral => octahedral(d),
    };
    let (width, height) = (i64::from(image.width), i64::from(image.height));
    let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
    let (fx, fy) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
    let (x, y) = (x.floor() as i64, y.floor() as i64);
    let mut sum = [0.0; 4];
    for (dx, dy, weight) in
        [(0, 0, (1.0 - fx) * (1.0 - fy)), (1, 0, fx * (1.0 - fy)), (0, 1, (1.0 - fx) * fy), (1, 1, fx * fy)]
    {
        let (x, y) = wrapped(layout, x + dx, y + dy, width, height);
        let texel = image.texels.linear((y * width + x) as usize);
        sum.iter_mut().zip(texel).for_each(|(sum, x)| *sum += weight * x.max(0.0));
    }
    sum[3] = 1.0;
    sum
}

/// A texel beyond the edge, which the sphere has elsewhere.
fn wrapped(layout: Layout, x: i64, y: i64, width: i64, height: i64) -> (i64, i64) {
    if layout == Layout::LatLong {
        return (x.rem_euclid(width), y.clamp(0, height - 1));
    }
    let (mut x, mut y) = (x, y);
    if x < 0 || x >= width {
        x = if x < 0 { -1 - x } else { 2 * width - 1 - x };
        y = height - 1 - y;
    }
    if y < 0 || y >= height {
        y = if y < 0 { -1 - y } else { 2 * height - 1 - y };
        x = width - 1 - x;
    }
    (x.clamp(0, width - 1), y.clamp(0, height - 1))
}

/// Where a unit direction lies on the octahedral map, in [0, 1]².
fn octahedral(d: DVec3) -> (f64, f64) {
    let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
    let r = (1.0 - z).max(0.0).sqrt();
    let phi = y.atan2(x) * FRAC_2_PI;
    let (mut u, mut v) = (r - phi * r, phi * r);
    if d.z < 0.0 {
        (u, v) = (1.0 - v, 1.0 - u);
    }
    (0.5 * (u.copysign(d.x) + 1.0), 0.5 * (v.copysign(d.y) + 1.0))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    /// The inverse of [`octahedral`], by the paper.
    fn direction(u: f64, v: f64) -> DVec3 {
        let (u, v) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        let distance = 1.0 - (u.abs() + v.abs());
        let r = 1.0 - distance.abs();
        let phi = if r == 0.0 { FRAC_PI_4 } else { ((v.abs() - u.abs()) / r + 1.0) * FRAC_PI_4 };
        let scale = r * (2.0 - r * r).max(0.0).sqrt();
        let z = (1.0 - r * r).copysign(distance);
        DVec3::new(phi.cos().copysign(u) * scale, phi.sin().copysign(v) * scale, z)
    }

    #[test]
    fn octahedral_there_and_back() {
        for i in 0..20 {
            for j in 0..20 {
                let (u, v) = ((f64::from(i) + 0.5) / 20.0, (f64::from(j) + 0.5) / 20.0);
                let d = direction(u, v);
                let (u1, v1) = octahedral(d);
                assert!((u - u1).abs() + (v - v1).abs() <= 1e-9, "{u} {v}: {d} {u1} {v1}");
            }
        }
    }

    /// An image of what each direction's components are, found again by the scene's convention.
    #[test]
    fn directions_keep_their_colours() {
        for (layout, width, height) in [(Layout::Octahedral, 64, 64), (Layout::LatLong, 128, 64)] {
            let texels: Vec<[f32; 4]> = (0..width * height)
                .map(|i| {
                    let (u, v) = (
                        (f64::from(i % width) + 0.5) / f64::from(width),
                        (f64::from(i / width) + 0.5) / f64::from(height),
                    );
                    let d = match layout {
                        Layout::Octahedral => direction(u, v),
                        Layout::LatLong => {
                            let (sin, cos) = (PI * v).sin_cos();
                            DVec3::new(sin * (TAU * u).cos(), sin * (TAU * u).sin(), cos)
                        }
                    };
                    (d * 0.5 + 0.5).as_vec3().extend(1.0).to_array()
                })
                .collect();
            let image = Image { name: String::new(), width, height, texels: Texels::Float(texels.into()) };
            for world_from_light in [
                DMat4::IDENTITY,
                DMat4::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.0),
                DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)),
                DMat4::from_scale(DVec3::new(-2.0, 2.0, 2.0)) * DMat4::from_rotation_x(-1.5),
            ] {
                let mirrored = world_from_light.determinant() < 0.0;
                let map = resampled(&image, layout, mirrored);
                let world_from_environment = rotation(world_from_light).unwrap().as_dmat3();
                assert!((world_from_environment.determinant() - 1.0).abs() <= 1e-6);
                for (u, v) in [(0.3, 0.2), (0.5, 0.5), (0.9, 0.7), (0.05, 0.45)] {
                    let (column, row) =
                        ((u * f64::from(map.width)) as u32, (v * f64::from(map.height)) as u32);
                    let (u, v) = (
                        (f64::from(column) + 0.5) / f64::from(map.width),
                        (f64::from(row) + 0.5) / f64::from(map.height),
                    );
                    let (sin, cos) = (PI * v).sin_cos();
                    let (x, z) = ((TAU * (u - 0.5)).sin(), -(TAU * (u - 0.5)).cos());
                    let world = world_from_environment * DVec3::new(sin * x, cos, sin * z);
                    let light = DMat3::from_mat4(world_from_light).inverse() * world;
                    let wanted = light.normalize() * 0.5 + 0.5;
                    let [r, g, b, _] = map.texels.linear((row * map.width + column) as usize);
                    let found = DVec3::new(r.into(), g.into(), b.into());
                    assert!((found - wanted).abs().max_element() <= 0.02, "{layout:?} {found} {wanted}");
                }
            }
        }
    }

    #[test]
    fn a_texel_alone() {
        let image =
            Image { name: String::new(), width: 1, height: 1, texels: Texels::Float([[2.0; 4]].into()) };
        for layout in [Layout::LatLong, Layout::Octahedral] {
            let map = resampled(&image, layout, true);
            assert!((0..map.texels.len()).all(|i| map.texels.linear(i) == [2.0, 2.0, 2.0, 1.0]));
        }
        assert_eq!(rotation(DMat4::ZERO), None);
    }
}
