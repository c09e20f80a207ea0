//! The mistakes that the proofs must catch.

/// One deliberate mistake: a replacement in one kernel source.
#[derive(Clone, Copy, Debug)]
pub struct Mutant {
    /// What `--only` takes.
    pub name: &'static str,
    /// Under `crates/kernels/wgsl`.
    pub file: &'static str,
    /// Occurs there exactly once.
    pub find: &'static str,
    /// What takes its place.
    pub replace: &'static str,
    /// The proofs that are run: those whose name contains it.
    pub caught_by: &'static str,
}

/// Proofs that a mutant must upset.
const FACING_SQUARES: &str = "facing_squares";
const LIT_SPHERE: &str = "a_closed_sphere_with_an_area_light";
const LAMP_IN_GLASS: &str = "a_lamp_in_glass";
const RAYS_COUNTED: &str = "one_kernel_counts_the_integrators_rays";
const IN_ROUGH_GLASS: &str = "a_camera_in_rough_glass";
const FURNACES: &str = "a_white_furnace";
const SMALL_POOL: &str = "a_pool_of_two_paths";
const SHADING_NORMALS: &str = "integrators_agree_on_shading_normals";
const MATERIALS: &str = "integrators_agree_on_every_material";
const SKY: &str = "a_floor_under_an_image_of_a_sky";
const POINT_LIGHT: &str = "a_floor_under_a_point_light";
const LENS: &str = "a_lens_half_covered";
const PARALLEL_RAYS: &str = "facing_squares_by_parallel_rays";
const FILTERS: &str = "an_edge_has_the_filters_profile";
const CROPS: &str = "a_crop_has_the_bits_of_the_whole";
const NORMAL_MAPS: &str = "a_map_lies_the_same";
const DISPERSION: &str = "that_disperses_has_each_channels_index";
const GPU_SAMPLES: &str = "a_gpu_renders_the_same_samples";
const LIGHT_TREE: &str = "light_tree::";

/// The mutants.
pub const MUTANTS: &[Mutant] = &[
    Mutant {
        name: "dropped-cosine",
        file: "bindings/light_join.wgsl",
        find: "(abs(dot(vertex.surface.ng, light.wi)) / light.pdf * weight * estimator)",
        replace: "(1.0 / light.pdf * weight * estimator)",
        caught_by: FACING_SQUARES,
    },
    Mutant {
        name: "swapped-pdf-fwd-rev",
        file: "bindings/vertex.wgsl",
        find: "factor, cos_out, pdf_fwd, pdf_rev, vertex.ending",
        replace: "factor, cos_out, pdf_rev, pdf_fwd, vertex.ending",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "missing-light-pmf",
        file: "bindings/lights.wgsl",
        find: "light.pmf / light.measure",
        replace: "1.0 / light.measure",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "missing-eta-squared",
        file: "lib/bsdf_sampling.wgsl",
        find: "select(adjoint, 1.0 / (eta * eta), mode == TRANSPORT_RADIANCE)",
        replace: "adjoint",
        caught_by: LAMP_IN_GLASS,
    },
    Mutant {
        name: "rough-refraction-without-eta-squared",
        file: "lib/bsdf_terms.wgsl",
        find: "select(f, f / (eta * eta), bends(material))",
        replace: "f",
        caught_by: IN_ROUGH_GLASS,
    },
    Mutant {
        name: "join-through-the-medium-behind",
        file: "bindings/material.wgsl",
        find: "select(medium, select(NONE, surface.material, cos_i < 0.0), crosses)",
        replace: "medium",
        caught_by: MATERIALS,
    },
    Mutant {
        name: "join-by-greens-index",
        file: "bindings/join.wgsl",
        find: "shade_surface(y_surface, stored.throughput)",
        replace: "shade_surface(y_surface, vec3<f32>(0.0, 1.0, 0.0))",
        caught_by: DISPERSION,
    },
    Mutant {
        name: "splat-not-divided-by-light-paths",
        file: "bindings/splat.wgsl",
        find: "cosine * pdf_camera / params.splat_factor * strategy_weight",
        replace: "cosine * pdf_camera * strategy_weight",
        caught_by: FACING_SQUARES,
    },
    Mutant {
        name: "reservoir-weight-n-over-k",
        file: "bindings/join_choice.wgsl",
        find: "f32(n) / f32(min(params.k, n))",
        replace: "f32(n) / f32(params.k)",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "reservoir-without-choice-chance",
        file: "bindings/join_choice.wgsl",
        find: "total / (f32(params.k) * importance)",
        replace: "f32(n) / f32(params.k)",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "joins-beyond-four-dropped",
        file: "list_joins.wgsl",
        find: "select(0u, end, end < n_joins)",
        replace: "0u",
        caught_by: FURNACES,
    },
    Mutant {
        name: "joins-listed-twice",
        file: "list_joins.wgsl",
        find: "found[listed + i]",
        replace: "found[i]",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "joins-ruled-out-by-the-wrong-side",
        file: "list_joins.wgsl",
        find: "stored.wo, -wi)",
        replace: "stored.wo, wi)",
        caught_by: GPU_SAMPLES,
    },
    Mutant {
        name: "pool-factor-inverted",
        file: "bindings/join_choice.wgsl",
        find: "f32(n_vertices) / (f32(params.k) * f32(params.n_light_paths))",
        replace: "(f32(params.k) * f32(params.n_light_paths)) / f32(n_vertices)",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "pool-count-in-mis-weight",
        file: "bindings/join.wgsl",
        find: "let config = mis_config();",
        replace: "var config = mis_config(); if (has_flag(FLAG_POOL) && params.join == JOIN_K_STEP) { \
                  config.join = f32(params.k * params.n_light_paths) / f32(light_paths[pool_size_at()]); }",
        caught_by: SMALL_POOL,
    },
    Mutant {
        name: "pool-never-regenerated",
        file: "bindings/start_light.wgsl",
        find: "params.first_sample + select(in_pass / params.n_pixels, 0u, pool)",
        replace: "select(params.first_sample + in_pass / params.n_pixels, 0u, pool)",
        caught_by: SMALL_POOL,
    },
    Mutant {
        name: "ending-chance-omitted",
        file: "connect_ends.wgsl",
        find: "1.0 / (y_ending * z_ending)",
        replace: "1.0",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "nee-counted-twice",
        file: "bindings/light_join.wgsl",
        find: "return mis_weight_emitter(",
        replace: "return 2.0 * mis_weight_emitter(",
        caught_by: FACING_SQUARES,
    },
    Mutant {
        name: "join-without-inverse-square",
        file: "bindings/join.wgsl",
        find: "cosines.x * cosines.y / distance_squared",
        replace: "cosines.x * cosines.y",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "adjoint-factor-dropped",
        file: "lib/bsdf_diffuse.wgsl",
        find: "* adjoint_cosines(frame, wo, wi, mode);",
        replace: "* 1.0;",
        caught_by: SHADING_NORMALS,
    },
    Mutant {
        name: "roulette-not-divided-by-survival",
        file: "bindings/vertex.wgsl",
        find: "scattered.weight / survival;",
        replace: "scattered.weight;",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "waiting-paths-counted-as-rays",
        file: "plan_queue.wgsl",
        find: "length - atomicLoad(&counters[COUNT_WAITING])",
        replace: "length",
        caught_by: RAYS_COUNTED,
    },
    Mutant {
        name: "roulette-divided-by-another-survival",
        file: "bindings/camera_step.wgsl",
        find: "scatter(path, vertex, survival, factor",
        replace: "scatter(path, vertex, vertex.survival, factor",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "hit-weight-without-emission-density",
        file: "lib/mis.wgsl",
        find: "factor_s1 * pdf_direct_area) + state.dvc * mis_power(config, pdf_emission);",
        replace: "factor_s1 * pdf_direct_area);",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "splat-weight-without-its-rivals",
        file: "lib/mis.wgsl",
        find: "mis_weight(config, config.splat, mis_power(config, pdf_y_area) * light_earlier)",
        replace: "mis_weight(config, config.splat, 0.0)",
        caught_by: LIT_SPHERE,
    },
    Mutant {
        name: "delta-vertex-keeps-its-strategy",
        file: "lib/mis.wgsl",
        find: "MisState(0.0, mis_power(config, cos_out) * state.dvc, ending)",
        replace: "MisState(state.dvcm, mis_power(config, cos_out) * state.dvc, ending)",
        caught_by: FURNACES,
    },
    Mutant {
        name: "environment-hit-without-its-rivals",
        file: "bindings/camera_step.wgsl",
        find: "weight = mis_weight_hit(config, path.mis, factor, pdf_position * ratio, pdf_emission);",
        replace: "weight = mis_weight_hit(config, path.mis, factor, 0.0, pdf_emission);",
        caught_by: SKY,
    },
    Mutant {
        name: "environment-density-per-image-area",
        file: "lib/environment.wgsl",
        find: "return middle * sin_quarter(half_step) / (half_step * length(direction.xz));",
        replace: "return 1.0;",
        caught_by: SKY,
    },
    Mutant {
        name: "point-light-that-can-be-hit",
        file: "bindings/lights.wgsl",
        find: "1.0 / light.measure, 0.0);",
        replace: "1.0 / light.measure, 1.0);",
        caught_by: POINT_LIGHT,
    },
    Mutant {
        name: "splats-through-the-middle-of-the-lens",
        file: "bindings/splat.wgsl",
        find: "let start = camera_start(params.camera, film_point.xy, lens);",
        replace: "let start = params.camera.origin;",
        caught_by: LENS,
    },
    Mutant {
        name: "parallel-rays-spread",
        file: "bindings/vertex.wgsl",
        find: "select(hit.t * hit.t, 1.0, path.parallel)",
        replace: "hit.t * hit.t",
        caught_by: PARALLEL_RAYS,
    },
    Mutant {
        name: "splat-without-its-filters-sum",
        file: "bindings/splat.wgsl",
        find: "column.weight * row.weight",
        replace: "1.0",
        caught_by: FILTERS,
    },
    Mutant {
        name: "random-numbers-by-the-pixel-of-the-crop",
        file: "bindings/start_camera.wgsl",
        find: "let ray = camera_sample(pixel, sample);",
        replace: "let ray = camera_sample(in_pass % params.n_pixels, sample);",
        caught_by: CROPS,
    },
    Mutant {
        name: "normal-map-upside-down",
        file: "bindings/shaded.wgsl",
        find: "map.row_v.y < 0.0",
        replace: "false",
        caught_by: NORMAL_MAPS,
    },
    Mutant {
        name: "hits-weigh-draws-by-power",
        file: "bindings/camera_step.wgsl",
        find: "vertex.mis, factor, pdf_position * ratio",
        replace: "vertex.mis, factor, pdf_position",
        caught_by: LIGHT_TREE,
    },
    Mutant {
        name: "escapes-weigh-draws-by-power",
        file: "bindings/camera_step.wgsl",
        find: "path.mis, factor, pdf_position * ratio",
        replace: "path.mis, factor, pdf_position",
        caught_by: LIGHT_TREE,
    },
    Mutant {
        name: "hits-forget-the-side-that-was-lit",
        file: "bindings/vertex.wgsl",
        find: "LightPlace(path.origin, facing_normal(path.facing))",
        replace: "LightPlace(path.origin, vec3<f32>(0.0))",
        caught_by: LIGHT_TREE,
    },
    Mutant {
        name: "light-paths-weigh-draws-by-power",
        file: "bindings/light_step.wgsl",
        find: "vertex.mis.dvcm *= mis_power(mis_config(), ratio);",
        replace: "vertex.mis.dvcm *= 1.0;",
        caught_by: LIGHT_TREE,
    },
    Mutant {
        name: "light-paths-begin-by-the-trees-chance",
        file: "bindings/light_join.wgsl",
        find: "light.pdf, light.pdf_position, pdf_emit",
        replace: "light.pdf, light.pdf, pdf_emit",
        caught_by: LIGHT_TREE,
    },
];

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::mutants::workspace;

    #[test]
    fn every_mutant_changes_one_place() {
        for mutant in MUTANTS {
            let path = workspace().join("crates/kernels/wgsl").join(mutant.file);
            let text = std::fs::read_to_string(&path).unwrap();
            assert_eq!(text.matches(mutant.find).count(), 1, "{}: {:?}", mutant.name, mutant.find);
            assert_ne!(mutant.find, mutant.replace, "{}", mutant.name);
            assert!(!mutant.find.contains("=>"), "{}: the build script splits there", mutant.name);
        }
    }

    #[test]
    fn names_are_distinct() {
        let names: HashSet<_> = MUTANTS.iter().map(|mutant| mutant.name).collect();
        assert_eq!(names.len(), MUTANTS.len());
        assert!(names.len() >= 14);
    }
}
