//! The renderer, as the rest of the program sees it: flags in, images and failures out.

use std::{sync::Arc, time::Duration};

use midway_device::{Device, DeviceInfo, MemoryPlan};
use midway_film::{Channel, Image};
use midway_render::{
    Choice, Crop, FilterKind, Integrator, IntegratorSettings, Join, JoinChoice, LightPaths, LightSampling,
    Mis, PixelFilter, RenderError, RenderSettings, RenderStats, Renderer, Rng, Team,
};
use midway_scene::Scene;

use super::{frame::Frame, schedule::Job};
use crate::{
    args::{
        FilterArg, IntegratorArg, JoinArg, JoinChoiceArg, LightPathsArg, LightSamplingArg, MisArg,
        RenderArgs, RngArg,
    },
    status::{Failure, Outcome, Status},
};

/// Several devices render this long before they are looked at: what one has then begun, others wait for.
const ROUND: Duration = Duration::from_millis(200);

/// A render in progress.
pub struct RenderJob {
    team: Team,
    stats: RenderStats,
}

impl RenderJob {
    /// Packs the scene and takes the devices' memory. Kernels of `also` are compiled at the same time.
    ///
    /// # Errors
    /// With the status of [`failure`].
    pub fn start(
        devices: &[Arc<dyn Device>],
        scene: &Scene,
        frame: &Frame,
        settings: &RenderSettings,
        also: &[RenderSettings],
        tell: impl FnOnce(&MemoryPlan),
    ) -> Outcome<Self> {
        let team = Team::new(devices, scene, &frame.camera, settings, also, tell).map_err(failure)?;
        Ok(Self { team, stats: RenderStats::default() })
    }

    /// Goes on by the integrator that `auto` chooses, on the first device.
    ///
    /// # Errors
    /// With the status of [`failure`].
    pub fn choose(&mut self) -> Outcome<Choice> {
        let choice = midway_render::choose(self.team.lead()).map_err(failure)?;
        let settings = self.team.lead().settings().clone();
        let chosen = RenderSettings { integrator: choice.integrator(), ..settings };
        self.team.set_settings(&chosen).map_err(failure)?;
        Ok(choice)
    }

    /// The integrator with its options, for people and headers.
    pub fn integrator(&self) -> String {
        self.team.lead().settings().integrator.describe()
    }

    /// Every bias that was asked for.
    pub fn bias(&self) -> Vec<String> {
        self.team.lead().settings().bias()
    }

    /// Where its random numbers come from, for headers.
    pub fn rng(&self) -> String {
        self.team.lead().settings().rng.describe()
    }

    /// How lights are chosen where they are sampled, for headers.
    pub fn light_sampling(&self) -> &'static str {
        match self.team.lead().samples_lights_by_tree() {
            Some(true) => "tree",
            Some(false) => "power",
            None => "none",
        }
    }

    /// The pixel filter, for headers.
    pub fn filter(&self) -> String {
        self.team.lead().settings().filter.describe()
    }

    /// The renderer that has all samples so far.
    ///
    /// # Errors
    /// If a device fails.
    pub fn renderer(&mut self) -> Outcome<&mut Renderer> {
        self.team.gathered().map_err(failure)
    }

    /// The channels of the layers that were asked for.
    ///
    /// # Errors
    /// If the device fails.
    pub fn channels(&mut self) -> Outcome<Vec<Channel>> {
        let renderer = self.renderer()?;
        let mut channels = renderer.channels().map_err(failure)?;
        channels.extend(renderer.group_channels().map_err(failure)?);
        Ok(channels)
    }

    /// The buffers that it took on the first device.
    pub fn memory(&self) -> &MemoryPlan {
        self.team.lead().plan()
    }

    /// What it had counted after the last pass.
    pub fn stats(&self) -> &RenderStats {
        &self.stats
    }
}

impl Job for RenderJob {
    fn step(&mut self, limit: u64) -> Outcome {
        self.team.step(limit.min(u32::MAX.into()), ROUND).map_err(failure)?;
        self.stats = self.team.stats().map_err(failure)?;
        Ok(())
    }

    fn samples(&self) -> u64 {
        self.team.samples()
    }

    fn rays(&self) -> u64 {
        self.stats.rays
    }

    fn image(&mut self) -> Outcome<Image> {
        self.renderer()?.image().map_err(failure)
    }
}

/// The first device's limits, by the names of all.
pub fn common_info(devices: &[Arc<dyn Device>]) -> DeviceInfo {
    let names: Vec<&str> = devices.iter().map(|device| device.info().name.as_str()).collect();
    DeviceInfo { name: names.join(" + "), ..devices[0].info().clone() }
}

/// The exit code of each way in which a render can fail.
pub fn failure(error: RenderError) -> Failure {
    let status = match error {
        RenderError::Settings(_) | RenderError::PathTooLong { .. } => Status::Usage,
        RenderError::Scene(_) | RenderError::Accel(_) | RenderError::TooManyTexels => Status::Input,
        RenderError::Device(_) => Status::Device,
    };
    Failure::new(status, error)
}

/// The flags in the renderer's terms.
pub fn settings(args: &RenderArgs, frame: &Frame) -> RenderSettings {
    RenderSettings {
        width: frame.width,
        height: frame.height,
        crop: frame.crop.map(|crop| Crop { x: crop.x, y: crop.y, width: crop.width, height: crop.height }),
        seed: args.seed,
        filter: filter(args),
        aovs: args.aov.0.clone(),
        light_groups: args.light_groups.is_some(),
        integrator: integrator(args),
        light_sampling: match args.light_sampling {
            LightSamplingArg::Auto => LightSampling::Auto,
            LightSamplingArg::Power => LightSampling::Power,
            LightSamplingArg::Tree => LightSampling::Tree,
        },
        max_path_length: args.max_path_length,
        rng: match args.rng {
            RngArg::Sobol => Rng::Sobol,
            RngArg::Hash => Rng::Hash,
            RngArg::Table(entries) => Rng::Table(entries),
        },
        clamp: args.clamp,
        ..RenderSettings::default()
    }
}

fn filter(args: &RenderArgs) -> PixelFilter {
    let usual = PixelFilter::new(match args.filter {
        FilterArg::Box => FilterKind::Box,
        FilterArg::BlackmanHarris => FilterKind::BlackmanHarris,
    });
    PixelFilter { width: args.filter_width.unwrap_or(usual.width), ..usual }
}

/// Flags that were not given leave the renderer's defaults.
pub fn integrator(args: &RenderArgs) -> IntegratorSettings {
    let defaults = IntegratorSettings::default();
    IntegratorSettings {
        integrator: match args.integrator {
            IntegratorArg::PathNaive => Integrator::PathNaive,
            // Until the warm-up has chosen.
            IntegratorArg::Auto | IntegratorArg::Path => Integrator::Path,
            IntegratorArg::Light => Integrator::Light,
            IntegratorArg::Bdpt => Integrator::Bdpt,
        },
        join: args.join.map_or(defaults.join, |join| match join {
            JoinArg::Full => Join::Full,
            JoinArg::KStep => Join::KStep,
            JoinArg::SingleStep => Join::SingleStep,
        }),
        k: args.k.unwrap_or(defaults.k),
        join_choice: args.join_choice.map_or(defaults.join_choice, |choice| match choice {
            JoinChoiceArg::Uniform => JoinChoice::Uniform,
            JoinChoiceArg::Importance => JoinChoice::Importance,
        }),
        light_paths: args.light_paths.map_or(defaults.light_paths, |paths| match paths {
            LightPathsArg::PerSample => LightPaths::PerSample,
            LightPathsArg::Pool(count) => LightPaths::Pool(count),
        }),
        nee: args.nee,
        splat: args.splat,
        mis: args.mis.map_or(defaults.mis, |mis| match mis {
            MisArg::Balance => Mis::Balance,
            MisArg::Power => Mis::Power,
        }),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Command};

    fn integrator_of(flags: &[&str]) -> IntegratorSettings {
        let line = ["midway", "render", "s.gltf"].iter().chain(flags);
        let Command::Render(args) = Cli::try_parse_from(line).unwrap().command else { unreachable!() };
        integrator(&args)
    }

    #[test]
    fn the_help_states_the_renderers_defaults() {
        let defaults = integrator_of(&[]);
        assert_eq!(defaults, IntegratorSettings::default());
        assert_eq!((defaults.integrator, defaults.join), (Integrator::Path, Join::Full));
        assert_eq!((defaults.k, defaults.join_choice), (3, JoinChoice::Uniform));
        assert_eq!((defaults.light_paths, defaults.mis), (LightPaths::PerSample, Mis::Power));
    }

    #[test]
    fn flags_arrive() {
        let line = "-i bdpt --join k-step --k 5 --join-choice importance --light-paths pool:9 --mis balance \
                    --nee=false --splat";
        let flags: Vec<&str> = line.split_whitespace().collect();
        let expected = IntegratorSettings {
            integrator: Integrator::Bdpt,
            join: Join::KStep,
            k: 5,
            join_choice: JoinChoice::Importance,
            light_paths: LightPaths::Pool(Some(9)),
            nee: Some(false),
            splat: Some(true),
            mis: Mis::Balance,
        };
        assert_eq!(integrator_of(&flags), expected);
    }
}
