//! Records as JSON and CSV, tables.

use serde_json::{Map, Value, json};
use zimm::prelude::*;

/// Numbers under their names, in order.
pub(crate) type Record = Vec<(String, Value)>;

/// Means and, under names that tell so, their errors.
pub(crate) fn with_errors(means: &[(&str, Mean)]) -> Record {
    let both = |(name, mean): &(&str, Mean)| {
        let error = (format!("{name}_error"), json!(mean.at_least()));
        [(name.to_string(), json!(mean.value)), error]
    };
    means.iter().flat_map(both).collect()
}

/// The names of those whose errors are lower bounds.
pub(crate) fn unsettled(means: &[(&str, Mean)]) -> Value {
    let unknown = |(_, mean): &&(&str, Mean)| mean.standard_error().is_none();
    means
        .iter()
        .filter(unknown)
        .map(|(name, _)| *name)
        .collect()
}

/// One JSON object and the end of the line.
pub(crate) fn json_line(record: Record) -> String {
    Value::from(Map::from_iter(record)).to_string() + "\n"
}

/// Comma-separated values under a line of names; what there is not is left empty.
pub(crate) fn csv(records: impl IntoIterator<Item = Record>) -> String {
    let mut lines = Vec::new();
    for record in records {
        let (names, values): (Vec<_>, Vec<_>) = record.into_iter().unzip();
        if lines.is_empty() {
            lines.push(names.join(","));
        }
        let words: Vec<_> = values.iter().map(word).collect();
        lines.push(words.join(","));
    }
    lines.join("\n") + "\n"
}

fn word(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Array(entries) => entries.iter().map(word).collect::<Vec<_>>().join(" "),
        other => other.to_string(),
    }
}

/// Columns flush right, two blanks apart.
pub(crate) fn aligned<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let line = |row: &[String; N]| {
        let cells: Vec<_> = row
            .iter()
            .zip(widths)
            .map(|(cell, width)| format!("{cell:>width$}"))
            .collect();
        cells.join("  ").trim_end().to_string() + "\n"
    };
    rows.iter().map(line).collect()
}
