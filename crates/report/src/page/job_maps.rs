//! The fields of one job as a page holds them.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};
use wording::visible;

use crate::field::{Field, FieldCodes, FieldGrid};

/// Up to this number of elements a value takes 16 bits, beyond it 8.
const FINELY_CODED: usize = 4096;

/// The fields of one job, as a page shows them.
#[derive(Clone, Debug)]
pub struct JobMaps {
    json: Value,
    size: usize,
}

impl JobMaps {
    /// Codes the fields of the job with a `key`, of which one holds states; `notes` are sentences
    /// above its maps.
    pub fn new(key: &str, notes: &[String], fields: &[Field]) -> Self {
        let grid = fields.first().map(Field::grid);
        let FieldGrid { nx, ny, origin, element } =
            grid.unwrap_or(FieldGrid { nx: 0, ny: 0, origin: [0.0; 2], element: [0.0; 2] });
        let bits = if nx * ny > FINELY_CODED { 8 } else { 16 };
        let maps: Vec<Value> = fields.iter().map(|field| map(field, bits)).collect();
        let json = json!({
            "key": visible(key),
            "notes": notes.iter().map(|note| visible(note)).collect::<Vec<_>>(),
            "nx": nx,
            "ny": ny,
            "origin": origin,
            "element": element,
            "maps": maps,
        });
        let size = json.to_string().len();
        Self { json, size }
    }

    /// Returns the number of bytes that it takes in a page.
    pub fn size(&self) -> usize {
        self.size
    }

    pub(super) fn json(&self) -> &Value {
        &self.json
    }
}

fn map(field: &Field, bits: u32) -> Value {
    let name = visible(field.name());
    match field.codes(bits) {
        FieldCodes::Number { low, high, shade, is_signed, codes } => json!({
            "name": name,
            "unit": visible(field.unit()),
            "low": low,
            "high": high,
            "shade": shade,
            "signed": is_signed,
            "bits": bits,
            "data": BASE64_STANDARD.encode(codes),
        }),
        FieldCodes::Category { states, names } => json!({
            "name": name,
            "unit": "",
            "names": names.iter().map(|name| visible(name)).collect::<Vec<_>>(),
            "data": BASE64_STANDARD.encode(states),
        }),
    }
}
