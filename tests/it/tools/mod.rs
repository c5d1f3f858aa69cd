#[cfg(all(unix, feature = "cli"))]
mod collections;

#[cfg(feature = "cli")]
mod files;

#[cfg(feature = "cli")]
mod hostile;

#[cfg(all(unix, feature = "cli"))]
mod identification;

#[cfg(feature = "cli")]
mod lint;

#[cfg(all(unix, feature = "cli"))]
mod repair;
