//! Sweeps: in memory or into a folder, and what is computed of all their rows.

use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use perirobot_march::Result;
use perirobot_march::progress::Progress;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::results::columns::poses_csv;
use perirobot_sweep::results::journal::Shard;
use perirobot_sweep::results::table::TableFormat;
use perirobot_sweep::results::{Results, Subject, rows, scores};
use perirobot_sweep::scoring::check::ONE_IN;
use perirobot_sweep::scoring::session::Session;
use perirobot_sweep::scoring::{Row, run_on};
use pyo3::prelude::*;

use crate::backends::{BackendWords, open_all};
use crate::watch::{Listener, run};

/// All rows of a sweep.
#[pyclass(frozen, module = "perirobot._perirobot")]
pub(crate) struct Swept {
    results: Mutex<Results>,
    /// `poses.csv`.
    poses: Vec<u8>,
}

#[pymethods]
impl Swept {
    /// The bytes of `scores.csv`.
    fn scores(&self, py: Python<'_>) -> PyResult<Vec<u8>> {
        run(py, None, |_| scores::csv(&self.results.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    /// The bytes of `poses.csv`.
    fn poses(&self) -> Vec<u8> {
        self.poses.clone()
    }
}

impl Swept {
    /// Of results, and the bytes of `poses.csv`.
    pub(crate) fn new(results: Results, poses: Vec<u8>) -> Swept {
        Swept { results: Mutex::new(results), poses }
    }
}

/// Sweeps in memory.
pub(crate) fn in_memory(
    (study, worlds): (&Study, &[World]),
    backend: &BackendWords,
    listener: &Listener,
) -> Result<(Vec<Row>, Swept)> {
    let mut backends = open_all(backend, listener)?;
    let rows = run_on(study, worlds, &mut backends, listener)?;
    let counts = rows.iter().map(|row| row.counts);
    let results = Results::from_counts(Subject::from_study(study, worlds), counts);
    Ok((rows, Swept::new(results, poses_csv(study, &worlds[0]))))
}

/// Sweeps into a folder, or finishes the same sweep there, as `perirobot sweep` does it.
pub(crate) fn into_folder(
    (study, worlds): (&Study, &[World]),
    folder: &Path,
    backend: &BackendWords,
    listener: &Listener,
) -> Result<()> {
    let begin = Instant::now();
    let command = ["perirobot.Study.sweep".to_string()];
    let mut session = Session::open(study, worlds, folder, Shard::WHOLE, false, &command)?;
    let left = session.total() - session.finished_count();
    listener.begins("poses", left);
    if left > 0 || session.is_unchecked() {
        let mut backends = open_all(backend, listener)?;
        session.run(&mut backends, ONE_IN, begin.elapsed().as_secs_f64(), listener)?;
        listener.check_stop()?;
    }
    let results = Results::new(Subject::from_study(study, worlds), session.into_pages());
    rows::write(&results, folder, TableFormat::Csv)?;
    scores::write(&results, folder, TableFormat::Csv)
}
