//! `--shard K/N`: the part of a sweep for this run. `auto` takes K from the environment of a workload manager.

use perirobot_march::{Error, Result};
use perirobot_sweep::results::journal::Shard;

/// Variables with a task's number: Slurm's array jobs, HyperQueue, Kubernetes' indexed jobs.
const NUMBERS: [&str; 3] = ["SLURM_ARRAY_TASK_ID", "HQ_TASK_ID", "JOB_COMPLETION_INDEX"];

/// Most shards; a larger number is a typo.
const MOST: u32 = 1_000_000;

/// A shard as given on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ShardArg {
    /// `None`: taken from the environment.
    number: Option<u32>,
    of: u32,
}

/// Reads `0/4` to `3/4`, or `auto/4`.
pub(super) fn shard(text: &str) -> Result<ShardArg, String> {
    let rule = || "must be K/N with K from 0 to N-1, or auto/N, as in 0/4 or auto/4".to_string();
    let (number, of) = text.split_once('/').ok_or_else(rule)?;
    let of = of.parse().ok().filter(|of| (1..=MOST).contains(of)).ok_or_else(rule)?;
    let number = match number {
        "auto" => None,
        number => Some(number.parse().ok().filter(|number| *number < of).ok_or_else(rule)?),
    };
    Ok(ShardArg { number, of })
}

impl ShardArg {
    /// The number of the shard.
    pub(super) fn resolve(self) -> Result<Shard> {
        let ShardArg { number, of } = self;
        let number = match number {
            Some(number) => number,
            None => engine_number(of, |name| std::env::var(name).ok())?,
        };
        Ok(Shard { number, of })
    }
}

/// The task number from the environment.
fn engine_number(of: u32, variable: impl Fn(&str) -> Option<String>) -> Result<u32> {
    let wrong = |what: String| Error::input(format!("--shard auto/{of}"), what);
    let mut found = NUMBERS.iter().filter_map(|name| Some((name, variable(name)?)));
    let (name, value) = found.next().ok_or_else(|| {
        wrong(format!(
            "none of {} is set: run it as a task of a workload manager, or write K/{of}",
            NUMBERS.join(", ")
        ))
    })?;
    if let Some((other, _)) = found.next() {
        return Err(wrong(format!(
            "both {name} and {other} are set: write the shard's number, as in 0/{of}"
        )));
    }
    let number = value.parse().ok().filter(|number| *number < of);
    number.ok_or_else(|| wrong(format!("{name} = {value}: must be from 0 to {}", of - 1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_as_people_write_them() {
        assert_eq!(shard("0/4"), Ok(ShardArg { number: Some(0), of: 4 }));
        assert_eq!(shard("3/4"), Ok(ShardArg { number: Some(3), of: 4 }));
        assert_eq!(shard("auto/16"), Ok(ShardArg { number: None, of: 16 }));
        for text in ["", "4", "4/4", "-1/4", "1/0", "auto", "auto/0", "a/4", "0/4/2", "0/1000001", "0.5/2"] {
            assert!(shard(text).unwrap_err().contains("K from 0 to N-1"), "{text}");
        }
    }

    #[test]
    fn the_environment_has_the_number() {
        let set = |all: &'static [(&str, &str)]| {
            move |name: &str| all.iter().find(|(known, _)| *known == name).map(|(_, value)| value.to_string())
        };
        for name in NUMBERS {
            let only = |wanted: &str| (wanted == name).then(|| "3".to_string());
            assert_eq!(engine_number(4, only).unwrap(), 3, "{name}");
        }
        for (all, expected) in [
            (&[][..], "none of SLURM_ARRAY_TASK_ID, HQ_TASK_ID, JOB_COMPLETION_INDEX is set"),
            (&[("HQ_TASK_ID", "4")], "HQ_TASK_ID = 4: must be from 0 to 3"),
            (&[("HQ_TASK_ID", "x")], "HQ_TASK_ID = x: must be from 0 to 3"),
            (
                &[("HQ_TASK_ID", "0"), ("SLURM_ARRAY_TASK_ID", "1")],
                "both SLURM_ARRAY_TASK_ID and HQ_TASK_ID are set",
            ),
        ] {
            let error = engine_number(4, set(all)).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
