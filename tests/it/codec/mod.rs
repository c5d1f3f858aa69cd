#[cfg(feature = "generate")]
mod damage;

mod errors;

#[cfg(feature = "generate")]
mod witnesses;
