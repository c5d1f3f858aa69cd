//! How `fuzz` and `minimise` call a decoder.

use std::ffi::OsString;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;

use ptm_conform::runner::processes;
use ptm_conform::runner::run::Decoder;

/// How a decoder is called.
#[derive(Args)]
pub struct CallArgs {
    /// Calls at a time; by default as many as there are processors.
    #[arg(long, value_name = "N")]
    pub jobs: Option<usize>,
    /// Wall-clock limit of a call.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
    /// Memory that a call may hold, all its processes together: bytes, or with K, M or G.
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = super::arguments::parse_size)]
    memory: u64,
    /// An exit status that means "malformed" besides 65.
    #[arg(long, value_name = "N", value_parser = super::arguments::parse_refusal)]
    reject_exit: Option<i32>,
}

impl CallArgs {
    /// The decoder that `command` starts; it gives up when `stop` is set.
    pub fn decoder(&self, command: &[OsString], stop: &Arc<AtomicBool>) -> Result<Decoder, String> {
        processes::prepare();
        let mut decoder = Decoder::new(command).map_err(|error| error.to_string())?;
        super::arguments::limit(&mut decoder, self.timeout, self.memory, stop)?;
        decoder.reject_exit = self.reject_exit;
        Ok(decoder)
    }
}
