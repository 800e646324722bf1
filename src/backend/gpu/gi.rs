//! The stages of indirect light, which run on the processor: their grids are read back, and written to the device again.

use glam::Vec4;

use super::{Gpu, GpuGrid, GpuPoints};
use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::gbuffer::GBuffer;
use crate::gi::GiSettings;
use crate::gi::gather::Gathered;
use crate::gi::indirect_filter::Window;
use crate::gi::ism::{IsmMaps, Slices};
use crate::gi::photons::PhotonMap;
use crate::gi::receivers::Receivers;
use crate::gi::vpl::Vpl;
use crate::job::Job;
use crate::reflect::MirrorGBuffer;

impl Gpu {
    fn copy_receivers(&mut self, receivers: &Receivers<Self>) -> Result<Receivers<Cpu>> {
        Ok(Receivers {
            size: receivers.size,
            position: self.copy(&receivers.position)?,
            normal: self.copy(&receivers.normal)?,
            view: self.copy(&receivers.view)?,
        })
    }

    fn copy_gathered(&mut self, gathered: &Gathered<Self>) -> Result<Gathered<Cpu>> {
        Ok(Gathered {
            irradiance: self.copy(&gathered.irradiance)?,
            residual: self.copy(&gathered.residual)?,
        })
    }

    fn put_receivers(&mut self, receivers: Receivers<Cpu>) -> Result<Receivers<Self>> {
        Ok(Receivers {
            size: receivers.size,
            position: self.put(receivers.position)?,
            normal: self.put(receivers.normal)?,
            view: self.put(receivers.view)?,
        })
    }

    pub(super) fn run_receivers(
        &mut self,
        gbuffer: &GBuffer<Self>,
        job: &Job,
    ) -> Result<Receivers<Self>> {
        let gbuffer = self.copy_gbuffer(gbuffer)?;
        let receivers = self.on_cpu(|cpu| cpu.receivers(&gbuffer, job))?;
        self.put_receivers(receivers)
    }

    pub(super) fn run_mirror_receivers(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        job: &Job,
    ) -> Result<Receivers<Self>> {
        let mirror = self.copy_mirror(mirror)?;
        let receivers = self.on_cpu(|cpu| cpu.mirror_receivers(&mirror, job))?;
        self.put_receivers(receivers)
    }

    pub(super) fn run_ism(
        &mut self,
        points: &GpuPoints,
        vpls: &[Vpl],
        slices: Slices,
        job: &Job,
    ) -> Result<IsmMaps<Self>> {
        let maps = self.on_cpu(|cpu| cpu.ism(&points.surfels, vpls, slices, job))?;
        Ok(IsmMaps {
            slices,
            keys: self.put(maps.keys)?,
        })
    }

    pub(super) fn run_gather(
        &mut self,
        receivers: &Receivers<Self>,
        vpls: &[Vpl],
        maps: &IsmMaps<Self>,
        interleave: u32,
        gathered: &mut Gathered<Self>,
        job: &Job,
    ) -> Result<()> {
        let receivers = self.copy_receivers(receivers)?;
        let maps = IsmMaps {
            slices: maps.slices,
            keys: self.copy(&maps.keys)?,
        };
        let mut sum = self.copy_gathered(gathered)?;
        self.on_cpu(|cpu| cpu.gather(&receivers, vpls, &maps, interleave, &mut sum, job))?;
        gathered.irradiance = self.put(sum.irradiance)?;
        gathered.residual = self.put(sum.residual)?;
        Ok(())
    }

    pub(super) fn run_indirect_filter(
        &mut self,
        receivers: &Receivers<Self>,
        irradiance: &GpuGrid<Vec4>,
        window: Window,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        let receivers = self.copy_receivers(receivers)?;
        let irradiance = self.copy(irradiance)?;
        let filtered =
            self.on_cpu(|cpu| cpu.indirect_filter(&receivers, &irradiance, window, job))?;
        self.put(filtered)
    }

    pub(super) fn run_photons(
        &mut self,
        receivers: &Receivers<Self>,
        map: &PhotonMap,
        irradiance: &mut GpuGrid<Vec4>,
        job: &Job,
    ) -> Result<()> {
        let receivers = self.copy_receivers(receivers)?;
        let mut sum = self.copy(irradiance)?;
        self.on_cpu(|cpu| cpu.photons(&receivers, map, &mut sum, job))?;
        *irradiance = self.put(sum)?;
        Ok(())
    }

    pub(super) fn run_add_indirect(
        &mut self,
        albedo: &GpuGrid<Vec4>,
        light: &Gathered<Self>,
        settings: &GiSettings,
        radiance: &mut GpuGrid<Vec4>,
        job: &Job,
    ) -> Result<()> {
        let (albedo, light) = (self.copy(albedo)?, self.copy_gathered(light)?);
        let mut sum = self.copy(radiance)?;
        self.on_cpu(|cpu| cpu.add_indirect(&albedo, &light, settings, &mut sum, job))?;
        *radiance = self.put(sum)?;
        Ok(())
    }
}
