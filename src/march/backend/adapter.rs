//! What is known of an adapter, and which one a user means.

use crate::Result;
use crate::error::{Argument, Issue, Site, Words};

/// What is known of an adapter before it is opened.
#[derive(Clone, Debug)]
pub struct AdapterReport {
    /// Its place in the list; it can be chosen by this number.
    pub index: usize,
    /// As the driver calls it.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
    /// `Vulkan`; `Metal` on macOS, and on Windows `Dx12`, too.
    pub backend: String,
    /// `DiscreteGpu`, `IntegratedGpu`, `VirtualGpu`, `Cpu` or `Other`.
    pub device_type: String,
    /// Whether the shaders run on the processor.
    pub software: bool,
    /// Largest buffer that a shader can see, in bytes.
    pub max_binding_bytes: u64,
    /// Largest buffer, in bytes.
    pub max_buffer_bytes: u64,
    /// Most workgroups on one axis of a dispatch.
    pub max_workgroups: u32,
    /// Most storage buffers that one kernel can see.
    pub max_storage_buffers: u32,
}

impl AdapterReport {
    /// Whether it is a GPU for certain: a virtual one may be software.
    #[cfg(feature = "gpu")]
    pub(crate) fn is_gpu(&self) -> bool {
        matches!(self.device_type.as_str(), "DiscreteGpu" | "IntegratedGpu")
    }

    /// For people and manifests: name, driver, backend, and whether it is software.
    pub fn label(&self) -> String {
        let software = if self.software { " (software)" } else { "" };
        format!("{}, {}, {}{software}", self.name, self.driver, self.backend)
    }
}

/// Which adapter to use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The first GPU: discrete before integrated before any other. Never a software adapter.
    Hardware,
    /// The first adapter that runs on the processor.
    Software,
    /// By its number in the list, or by a part of its name, driver or API in any case (the first that has it).
    Named(String),
}

impl std::str::FromStr for AdapterChoice {
    type Err = std::convert::Infallible;

    /// `hardware`, `software`, or anything else as [`AdapterChoice::Named`].
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text {
            "hardware" => AdapterChoice::Hardware,
            "software" => AdapterChoice::Software,
            name => AdapterChoice::Named(name.into()),
        })
    }
}

impl AdapterChoice {
    /// The choices of a text in which commas are between them: the devices that share the work of a sweep.
    ///
    /// # Errors
    /// When one of them is empty.
    pub fn parse_list(text: &str) -> Result<Vec<AdapterChoice>> {
        let parse = |name: &str| match name.trim() {
            "" => {
                let cure = "write numbers or parts of names with commas between them, as 0,1";
                let place = Site::Argument(Argument("adapter"), format!("{text:?}"));
                Err(Issue::says("has an empty name").with_advice(cure).with_place(place).into())
            }
            name => Ok(name.parse().unwrap_or_else(|never: std::convert::Infallible| match never {})),
        };
        text.split(',').map(parse).collect()
    }
}

/// The place of the chosen adapter in a list, or what to do about there being none.
pub fn select(adapters: &[AdapterReport], choice: &AdapterChoice) -> Result<usize> {
    let fail = |what: &str, cure: Words| Err(Issue::says(what).with_advice(cure).into());
    if adapters.is_empty() {
        let cure = "install the GPU vendor's driver, or software Vulkan (on Debian and Ubuntu `apt-get install \
                    mesa-vulkan-drivers libvulkan1`), or use ";
        return fail("no Vulkan adapter", Words::from(cure) + Argument("backend").quote("cpu"));
    }
    let known = || {
        let lines = adapters.iter().map(|a| format!("\n  {}: {}", a.index, a.label()));
        lines.collect::<String>()
    };
    match choice {
        AdapterChoice::Hardware => {
            let rank = |a: &AdapterReport| match a.device_type.as_str() {
                "DiscreteGpu" => 0,
                "IntegratedGpu" => 1,
                _ => 2,
            };
            match (0..adapters.len()).filter(|&i| !adapters[i].software).min_by_key(|&i| rank(&adapters[i])) {
                Some(index) => Ok(index),
                None => {
                    let cure = Words::from("use ")
                        + Argument("backend").quote("cpu")
                        + " or "
                        + Argument("adapter").quote("software")
                        + format!("; there are{}", known());
                    fail("no hardware adapter", cure)
                }
            }
        }
        AdapterChoice::Software => match adapters.iter().position(|a| a.software) {
            Some(index) => Ok(index),
            None => fail(
                "no software adapter",
                format!("on Debian and Ubuntu `apt-get install mesa-vulkan-drivers`; there are{}", known())
                    .into(),
            ),
        },
        AdapterChoice::Named(name) => {
            let lower = name.to_lowercase();
            let found = match name.parse::<usize>() {
                Ok(index) => (index < adapters.len()).then_some(index),
                Err(_) => adapters.iter().position(|a| a.label().to_lowercase().contains(&lower)),
            };
            match found {
                Some(index) => Ok(index),
                None => fail(
                    &format!("no adapter `{name}`"),
                    format!("choose a number or a part of a name of{}", known()).into(),
                ),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(index: usize, name: &str, device_type: &str) -> AdapterReport {
        AdapterReport {
            index,
            name: name.into(),
            driver: "1.0".into(),
            backend: "Vulkan".into(),
            device_type: device_type.into(),
            software: device_type == "Cpu",
            max_binding_bytes: 1 << 27,
            max_buffer_bytes: 1 << 31,
            max_workgroups: 65_535,
            max_storage_buffers: 8,
        }
    }

    fn office() -> Vec<AdapterReport> {
        vec![
            adapter(0, "llvmpipe (LLVM 15)", "Cpu"),
            adapter(1, "Tiny iGPU", "IntegratedGpu"),
            adapter(2, "Big GPU", "DiscreteGpu"),
        ]
    }

    #[track_caller]
    fn choose(adapters: &[AdapterReport], choice: &str) -> Result<usize, String> {
        select(adapters, &choice.parse().unwrap()).map_err(|e| e.to_string())
    }

    #[test]
    fn the_biggest_hardware_the_software_and_names() {
        let office = office();
        assert_eq!(choose(&office, "hardware"), Ok(2), "discrete before integrated");
        assert_eq!(choose(&office, "software"), Ok(0));
        assert_eq!(choose(&office, "LLVMpipe"), Ok(0));
        assert_eq!(choose(&office, "gpu"), Ok(1), "the first that has the name");
        assert_eq!(choose(&office, "2"), Ok(2));
    }

    #[test]
    fn a_list_names_each_device() {
        let list = |text: &str| AdapterChoice::parse_list(text).map_err(|e| e.to_string());
        let named = |name: &str| AdapterChoice::Named(name.into());
        assert_eq!(list("0, 2"), Ok(vec![named("0"), named("2")]));
        assert_eq!(list("Big GPU,software"), Ok(vec![named("Big GPU"), AdapterChoice::Software]));
        assert_eq!(list("hardware"), Ok(vec![AdapterChoice::Hardware]));
        for wrong in ["", "0,", ",1", "0,,1"] {
            assert!(list(wrong).unwrap_err().contains("as 0,1"), "{wrong:?}");
        }
    }

    #[test]
    fn refusals_name_the_cure() {
        let none = choose(&[], "hardware").unwrap_err();
        assert!(none.contains("mesa-vulkan-drivers libvulkan1") && none.contains("`backend cpu`"), "{none}");
        let software_only = choose(&office()[..1], "hardware").unwrap_err();
        assert!(software_only.contains("`adapter software`"), "{software_only}");
        let unknown = choose(&office(), "riva").unwrap_err();
        assert!(unknown.contains("`riva`") && unknown.contains("2: Big GPU"), "{unknown}");
        assert!(choose(&office(), "3").is_err());
        assert!(choose(&office()[1..], "software").is_err());
    }
}
