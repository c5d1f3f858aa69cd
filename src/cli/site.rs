//! `ptm-conform site`: writes pages about the format, its readers and the suite.

use std::path::PathBuf;

use clap::Args;

use crate::site::build;

use super::CommandResult;
use super::files::{read, with_path};
use super::output::{jobs, print, print_note};

/// Write the website: the annotated format, and a page for each case, misreading, ruling, lint code and reader.
///
/// The pages need no server; open index.html. Every example of the annotated format is executed, and nothing is written if one of
/// them fails.
#[derive(Args)]
#[command(after_help = "Example:\n  ptm-conform site --out site")]
pub struct SiteArgs {
    /// The output directory; other files in it are kept.
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// The reference decoder as WebAssembly, built from packages/wasm, for the page on which files can be dropped. The default is
    /// ptm_conform_wasm.wasm next to this program, as in release archives.
    #[arg(long, value_name = "FILE")]
    module: Option<PathBuf>,
    /// Number of files decoded in parallel; does not affect the result.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

/// Builds and writes the site.
pub fn run(args: &SiteArgs) -> CommandResult {
    let released = std::env::current_exe().ok();
    let released = released.map(|path| path.with_file_name("ptm_conform_wasm.wasm"));
    let released = released.filter(|path| path.is_file());
    let module = args.module.clone().or(released);
    let module = module.as_deref().map(read).transpose()?;
    let files = build(None, module.as_deref(), jobs(args.jobs)?)?;
    let mut bytes = 0;
    for file in &files {
        let path = args.out.join(&file.path);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(with_path(&path))?;
        }
        std::fs::write(&path, &file.bytes).map_err(with_path(&path))?;
        bytes += file.bytes.len();
    }
    let (count, size) = (files.len(), bytes.div_ceil(1_000_000));
    let index = args.out.join("index.html");
    print(&format!("{count} files, {size} MB: {}\n", index.display()));
    if module.is_none() {
        print_note(
            "the page \"Drop a file\" is left out, because it needs a WebAssembly module: --module FILE\n",
        );
    }
    Ok(0)
}
