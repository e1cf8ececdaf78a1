//! Harvest postures: the classes `HarvestStation` and `HarvestProgramme`.

pub mod programme;
mod settings;
pub mod station;
