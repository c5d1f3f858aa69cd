#[cfg(feature = "generate")]
mod damage;

#[cfg(feature = "generate")]
mod standard_images;

#[cfg(feature = "generate")]
mod witnesses;
