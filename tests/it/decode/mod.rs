#[cfg(unix)]
mod agreement;
mod compressed;
mod decoder_alone;
mod errors;
mod hostile_files;
mod real_file;
