//! `midway devices`.

use midway_device::{Bytes, DeviceInfo, DeviceKind, list_devices};
use serde_json::{Value, json};

use crate::{args::DevicesArgs, console, status::Outcome};

/// Prints every device with its memory and limits.
///
/// # Errors
/// If standard output cannot take it.
pub fn run(args: &DevicesArgs) -> Outcome {
    let devices = list_devices();
    if args.json {
        return console::output(&Value::from_iter(devices.iter().map(to_json)).to_string());
    }
    let mut rows =
        vec![["NAME", "KIND", "MEMORY", "LARGEST BUFFER", "LARGEST BINDING", "BACKEND"].map(String::from)];
    rows.extend(devices.iter().map(to_row));
    table(&rows).iter().try_for_each(|line| console::output(line))
}

/// The word for a kind of device.
pub fn kind_name(kind: DeviceKind) -> &'static str {
    match kind {
        DeviceKind::Cpu => "cpu",
        DeviceKind::Gpu => "gpu",
        DeviceKind::SoftwareGpu => "software-gpu",
    }
}

fn to_json(info: &DeviceInfo) -> Value {
    json!({
        "name": info.name,
        "kind": kind_name(info.kind),
        "backend": info.backend,
        "memory_bytes": info.memory_bytes,
        "max_buffer_bytes": info.max_buffer_bytes,
        "max_binding_bytes": info.max_binding_bytes,
        "max_storage_buffers": info.max_storage_buffers,
    })
}

fn to_row(info: &DeviceInfo) -> [String; 6] {
    [
        info.name.clone(),
        kind_name(info.kind).to_owned(),
        info.memory_bytes.map_or_else(|| "unknown".to_owned(), |bytes| Bytes(bytes).to_string()),
        Bytes(info.max_buffer_bytes).to_string(),
        Bytes(info.max_binding_bytes).to_string(),
        info.backend.clone(),
    ]
}

/// Lines with columns two spaces apart.
fn table<const N: usize>(rows: &[[String; N]]) -> Vec<String> {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let line = |row: &[String; N]| {
        let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::table;

    #[test]
    fn columns_line_up() {
        let rows = [["a", "bb"], ["ccc", "d"]].map(|row| row.map(String::from));
        assert_eq!(table(&rows), ["a    bb", "ccc  d"]);
    }
}
