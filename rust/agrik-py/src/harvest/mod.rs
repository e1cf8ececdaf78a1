//! Harvest postures: the class `HarvestStation`.

pub mod settings;
pub mod station;
