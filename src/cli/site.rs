//! `site`: the format, the suite and its readers as pages.

use std::path::PathBuf;

use clap::Args;

use ptm_conform::site::build;

use super::CommandResult;
use super::files::read;
use super::output::{jobs, print};

/// Write the site: the annotated format, a page for each case, misreading, ruling, lint code and reader.
///
/// Its pages need no server and ask none for anything; begin with index.html. Every example of the annotated format is
/// executed, and the site is not written if one does not hold.
#[derive(Args)]
pub struct SiteArgs {
    /// The output directory; existing files are kept, except those with the same names.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// The reference as WebAssembly, built from packages/wasm: adds a page on which files are dropped.
    #[arg(long, value_name = "FILE")]
    module: Option<PathBuf>,
    /// Files decoded at a time; the result does not depend on it.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

/// Builds the site and writes it.
pub fn run(args: &SiteArgs) -> CommandResult {
    let module = args.module.as_deref().map(read).transpose()?;
    let files = build(None, module.as_deref(), jobs(args.jobs)?)?;
    let mut bytes = 0;
    for file in &files {
        let path = args.out.join(&file.path);
        let named = |error: std::io::Error| format!("{}: {error}", path.display());
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(named)?;
        }
        std::fs::write(&path, &file.bytes).map_err(named)?;
        bytes += file.bytes.len();
    }
    print(&format!(
        "{} files, {} MB: {}\n",
        files.len(),
        bytes.div_ceil(1_000_000),
        args.out.join("index.html").display()
    ));
    Ok(0)
}
