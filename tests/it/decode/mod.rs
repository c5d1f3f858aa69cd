#[cfg(all(unix, feature = "cli"))]
mod agreement;
#[cfg(feature = "harness")]
mod compressed;
mod decoder_alone;
mod errors;
#[cfg(feature = "harness")]
mod hostile_files;
#[cfg(feature = "harness")]
mod real_file;
