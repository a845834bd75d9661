//! Tables as streams of Arrow, which other libraries take over as they are: its PyCapsule interface.

use std::sync::Arc;

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::Int32Type;
use arrow_array::{
    ArrayRef, DictionaryArray, Float64Array, Int32Array, Int64Array, RecordBatch, RecordBatchIterator,
    StringArray,
};
use arrow_schema::ArrowError;
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

/// A column as Python has it.
#[derive(FromPyObject)]
pub(crate) enum GivenColumn<'py> {
    /// Whole numbers.
    Counts(PyReadonlyArray1<'py, i64>),
    /// Scores, NaN where there is no value.
    Scores(PyReadonlyArray1<'py, f64>),
    /// Numbers, and the names that they count through.
    Names(PyReadonlyArray1<'py, i32>, Vec<String>),
}

impl GivenColumn<'_> {
    /// The same of Arrow: a score without a value is null, names are a dictionary.
    fn array(self) -> Result<ArrayRef, ArrowError> {
        Ok(match self {
            GivenColumn::Counts(all) => Arc::new(Int64Array::from(all.as_array().to_vec())),
            GivenColumn::Scores(all) => {
                let value = |&value: &f64| (!value.is_nan()).then_some(value);
                Arc::new(all.as_array().iter().map(value).collect::<Float64Array>())
            }
            GivenColumn::Names(of, all) => {
                let of = Int32Array::from(of.as_array().to_vec());
                Arc::new(DictionaryArray::<Int32Type>::try_new(of, Arc::new(StringArray::from(all)))?)
            }
        })
    }
}

/// A stream of one batch with these columns.
pub(crate) fn stream<'py>(
    py: Python<'py>,
    columns: Vec<(String, GivenColumn<'py>)>,
) -> PyResult<Bound<'py, PyCapsule>> {
    let wrong = |e: ArrowError| PyValueError::new_err(e.to_string());
    let arrays = columns.into_iter().map(|(name, column)| Ok((name, column.array()?, true)));
    let arrays: Vec<(String, ArrayRef, bool)> = arrays.collect::<Result<_, _>>().map_err(wrong)?;
    let batch = RecordBatch::try_from_iter_with_nullable(arrays).map_err(wrong)?;
    let schema = batch.schema();
    let stream = FFI_ArrowArrayStream::new(Box::new(RecordBatchIterator::new([Ok(batch)], schema)));
    PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
}
