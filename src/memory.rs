//! Memory of pictures, estimated before it is asked for: what does not fit is a sentence and no crash.

use glam::{UVec2, Vec4};

use crate::cloud::require_memory;
use crate::error::Result;
use crate::gbuffer::average::Pixel;
use crate::gbuffer::visibility::Sums;
use crate::gi::virtual_lights::VirtualLights;
use crate::gi::vpl::VPL_MAP_SIDE;
use crate::output::OutputKind;
use crate::parts::{Part, parts};
use crate::plan::{Plan, Stage};
use crate::reflect::sscr::heat::HeatSums;
use crate::settings::Settings;

/// A value of a grid of vectors.
const VECTOR: u64 = size_of::<Vec4>() as u64;

/// A pixel of the camera's G-buffer and its radiance.
const FRAME: u64 = 4 * VECTOR;

/// A pixel of the mirrors' G-buffer.
const MIRROR: u64 = 5 * VECTOR + 12;

/// A pixel while mirrors are searched: their surface, its regions, and the larger of the rays' picture and the pyramid that
/// closes holes (a third more than its finest level).
const REFLECTING: u64 = 2 * VECTOR + 16 + (size_of::<Pixel>() as u64 + VECTOR) * 4 / 3;

/// A pixel while a device splats: its key, count and sums.
const SPLATTING: u64 = 8 + size_of::<Sums>() as u64;

/// A pixel of a picture that receives indirect light: who receives it, and what was gathered.
const RECEIVING: u64 = 5 * VECTOR;

/// A pixel while what was gathered is merged.
const MERGING: u64 = 2 * VECTOR;

/// The shadow maps of a batch of virtual lights, and the tree for light by way of mirrors.
const INDIRECT: u64 = 160 << 20;

/// Working memory that does not grow with the picture.
const SPARE: u64 = 64 << 20;

/// Where a backend keeps its grids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum GridsIn {
    /// In main memory, where the products are then, too.
    MainMemory,
    /// In main memory that a software adapter asks for; the products are copies.
    SoftwareDevice,
    /// In a graphics card.
    Device,
}

/// What decides over the memory of a rendering.
pub(crate) struct Rendering<'a> {
    pub(crate) size: UVec2,
    pub(crate) lights: usize,
    pub(crate) plan: &'a Plan,
    pub(crate) settings: &'a Settings,
    pub(crate) outputs: &'a [OutputKind],
}

impl Rendering<'_> {
    /// Bytes of main memory, at the worst moment: what the frame leaves, and the largest of what mirrors take on the way,
    /// what indirect light takes, and what encoding the largest output takes.
    fn bytes(&self, grids: GridsIn) -> u64 {
        let pixels = self.pixels();
        let maps = if self.plan.runs(Stage::LightDepth, true) {
            self.lights as u64 * u64::from(self.settings.gi.light_map_size).pow(2) * 4
        } else {
            0
        };
        let frame = pixels * FRAME + maps;
        let frame = match grids {
            GridsIn::MainMemory => frame,
            GridsIn::SoftwareDevice => 2 * frame + pixels * (SPLATTING + VECTOR),
            GridsIn::Device => frame + pixels * VECTOR,
        };
        let reflects = self.plan.runs(Stage::Reflect, true);
        let held = if self.holds_mirrors() {
            // A software device holds the mirrors where the products are, too.
            let copies = if grids == GridsIn::SoftwareDevice {
                2
            } else {
                1
            };
            copies * pixels * MIRROR
        } else {
            0
        };
        let reflecting = if reflects { pixels * REFLECTING } else { 0 };
        let indirect = if self.plan.runs(Stage::Indirect, true) {
            let pictures = if reflects { 2 } else { 1 };
            let seen = u64::from(VPL_MAP_SIDE).pow(2) * 3 * VECTOR * self.lights as u64;
            pixels * (pictures * RECEIVING + MERGING) + seen + INDIRECT
        } else {
            0
        };
        let encoding = self.encoding();
        let kept = frame + held + self.heat() + self.lights_told();
        SPARE + kept + reflecting.max(encoding).max(indirect)
    }

    /// The same where the picture is made in parts of this size: one of them at a time, beside what all leave.
    fn bytes_in_parts(&self, part: UVec2, grids: GridsIn) -> u64 {
        let one = Rendering {
            size: part,
            outputs: &[],
            ..*self
        };
        let pixels = self.pixels();
        let mirrors = if self.holds_mirrors() {
            pixels * MIRROR
        } else {
            0
        };
        let kept = pixels * FRAME + mirrors + self.heat() + self.lights_told();
        one.bytes(grids) + kept + self.encoding()
    }

    fn pixels(&self) -> u64 {
        u64::from(self.size.x) * u64::from(self.size.y)
    }

    fn holds_mirrors(&self) -> bool {
        self.plan.runs(Stage::Reflect, true) || self.outputs.contains(&OutputKind::MirrorGBuffer)
    }

    /// Where searches end.
    fn heat(&self) -> u64 {
        let wanted = |output: &OutputKind| matches!(output, OutputKind::SearchHeat(_));
        if self.outputs.iter().any(wanted) {
            self.pixels() * size_of::<HeatSums>() as u64
        } else {
            0
        }
    }

    /// Virtual lights and their maps.
    fn lights_told(&self) -> u64 {
        if self.plan.runs(Stage::VirtualLights, true) {
            VirtualLights::most_bytes(&self.settings.gi)
        } else {
            0
        }
    }

    /// What encoding the largest output takes.
    fn encoding(&self) -> u64 {
        let outputs = self.outputs.iter();
        let bytes = outputs.map(|output| self.pixels() * output.bytes_per_pixel());
        bytes.max().unwrap_or(0)
    }

    /// [`crate::Error::Memory`] where the picture would not fit.
    pub(crate) fn require_memory(&self, grids: GridsIn) -> Result<()> {
        let UVec2 { x, y } = self.size;
        let largest = self.settings.image.part_size;
        let cut = parts(self.size, largest);
        let part = cut
            .iter()
            .map(Part::size)
            .max_by_key(|size| u64::from(size.x) * u64::from(size.y));
        let needed = match part.filter(|_| cut.len() > 1) {
            Some(part) => self.bytes_in_parts(part, grids),
            None => self.bytes(grids),
        };
        require_memory(&format!("a picture of {x} x {y} pixels"), needed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::PictureFormat;
    use crate::plan::SceneFacts;

    /// Under direct light alone.
    fn bytes(size: UVec2, mirror_points: u64, outputs: &[OutputKind], grids: GridsIn) -> u64 {
        let mut settings = Settings::default();
        settings.gi.vpl_count = 0;
        bytes_with(&settings, size, mirror_points, outputs, grids)
    }

    fn bytes_with(
        settings: &Settings,
        size: UVec2,
        mirror_points: u64,
        outputs: &[OutputKind],
        grids: GridsIn,
    ) -> u64 {
        let facts = SceneFacts {
            points: 100,
            mirror_points,
            lights: 1,
            environment: false,
        };
        let rendering = Rendering {
            size,
            lights: 1,
            plan: &Plan::new(&facts, settings),
            settings,
            outputs,
        };
        rendering.bytes(grids)
    }

    #[test]
    fn memory_grows_with_mirrors_outputs_and_copies() {
        let size = UVec2::new(1000, 1000);
        let picture = [OutputKind::Picture(PictureFormat::Png)];
        let least = bytes(size, 0, &picture, GridsIn::MainMemory);
        assert!(least > 68_000_000, "a picture of 1 million pixels: {least}");
        for (mirror_points, outputs, grids) in [
            (1, &picture[..], GridsIn::MainMemory),
            (0, &[OutputKind::CameraGBuffer], GridsIn::MainMemory),
            (0, &[OutputKind::MirrorGBuffer], GridsIn::MainMemory),
            (0, &picture, GridsIn::SoftwareDevice),
            (0, &picture, GridsIn::Device),
        ] {
            let more = bytes(size, mirror_points, outputs, grids);
            assert!(
                more > least,
                "{more} with {mirror_points} mirror points, {outputs:?} and grids in {grids:?}, {least} without"
            );
        }
    }

    #[test]
    fn virtual_lights_that_are_told_take_memory() {
        let settings = Settings::default();
        let facts = SceneFacts {
            points: 100,
            mirror_points: 0,
            lights: 1,
            environment: false,
        };
        let bytes = |plan: &Plan| {
            let rendering = Rendering {
                size: UVec2::new(100, 100),
                lights: 1,
                plan,
                settings: &settings,
                outputs: &[],
            };
            rendering.bytes(GridsIn::MainMemory)
        };
        let mut plan = Plan::new(&facts, &settings);
        let without = bytes(&plan);
        plan.ask_for_virtual_lights();
        let more = bytes(&plan) - without;
        // 512 lights of 5 bounces, 32 maps of 64 x 64 of each.
        let least = 5 * (512 * 112 + 32 * 64 * 64 * 4);
        assert!((least..10 * least).contains(&more), "{more} bytes more");
    }

    #[test]
    fn a_poster_needs_one_part_and_what_all_leave() {
        let mut settings = Settings::default();
        let facts = SceneFacts {
            points: 100,
            mirror_points: 1,
            lights: 1,
            environment: false,
        };
        let plan = Plan::new(&facts, &settings);
        let needed = |settings: &Settings| {
            let rendering = Rendering {
                size: UVec2::new(16_000, 16_000),
                lights: 1,
                plan: &plan,
                settings,
                outputs: &[],
            };
            let part = UVec2::splat(settings.image.part_size);
            (
                rendering.bytes_in_parts(part, GridsIn::MainMemory),
                rendering.bytes(GridsIn::MainMemory),
            )
        };
        let (parts, whole) = needed(&settings);
        let left = 16_000 * 16_000 * (FRAME + MIRROR);
        assert!(
            parts > left && parts < whole * 2 / 3,
            "{parts} of {whole}, {left} are left"
        );
        settings.image.part_size = 1024;
        let smaller = needed(&settings).0;
        assert!(smaller < parts && smaller > left, "{smaller}, {parts}");
    }

    #[test]
    fn a_picture_of_usual_size_fits_into_a_gigabyte() {
        let all = [
            OutputKind::Picture(PictureFormat::Exr),
            OutputKind::CameraGBuffer,
            OutputKind::MirrorGBuffer,
        ];
        let size = UVec2::new(1920, 1080);
        let indirect = Settings::default();
        let needed = bytes_with(&indirect, size, 1, &all, GridsIn::MainMemory);
        assert!(needed < 1 << 30, "{needed} bytes");
        let direct = bytes(size, 1, &all, GridsIn::MainMemory);
        assert!(
            needed > direct,
            "indirect light takes memory: {needed} bytes, {direct} without"
        );
    }
}
