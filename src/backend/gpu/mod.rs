//! Placeholder until the GPU backend lands.
use super::*;
/// stub
pub enum AdapterChoice {
    /// a
    Hardware,
    /// b
    Software,
    /// c
    Named(String),
}
impl std::str::FromStr for AdapterChoice {
    type Err = std::convert::Infallible;
    fn from_str(s: &str) -> std::result::Result<Self, Self::Err> {
        Ok(Self::Named(s.into()))
    }
}
/// stub
pub struct AdapterReport {
    /// a
    pub index: usize,
    /// a
    pub name: String,
    /// a
    pub device_type: String,
    /// a
    pub software: bool,
    /// a
    pub max_binding_bytes: u64,
    /// a
    pub max_buffer_bytes: u64,
    /// a
    pub max_workgroups: u32,
}
impl AdapterReport {
    /// a
    pub fn label(&self) -> String {
        String::new()
    }
}
/// stub
pub fn adapters() -> Vec<AdapterReport> {
    vec![]
}
/// stub
pub struct Gpu;
impl Gpu {
    /// stub
    pub fn new(_: &AdapterChoice) -> Result<Self> {
        Ok(Gpu)
    }
}
impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }
    fn device(&self) -> String {
        String::new()
    }
    fn load(&mut self, _: &Cell, _: &Rays) -> Result<()> {
        Ok(())
    }
    fn batch(&self) -> usize {
        1
    }
    fn score(&mut self, _: &[Placement]) -> Result<Vec<Vec<Confusion>>> {
        Ok(vec![])
    }
    fn read(&mut self, _: &Placement) -> Result<Evidence> {
        Err(crate::Error::Device(String::new()))
    }
}
