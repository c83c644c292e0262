//! Writes the manual pages of the program, one for each command, for `scripts/package`.
//!
//! ```text
//! cargo run --example manual -- DIRECTORY
//! ```

mod pages;

use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [directory] = &words[..] else {
        return Err("give the directory for the pages".into());
    };
    for page in pages::pages(tribosweep::usage())? {
        std::fs::write(Path::new(directory).join(page.file), page.text)?;
    }
    Ok(())
}
