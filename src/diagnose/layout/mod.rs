//! Where in a file a decoder looks for values: blocks, strides, tables and their indices.

pub(super) mod blocks;
pub(super) mod indices;
pub(super) mod provenance;
pub(super) mod strides;
pub(super) mod table_layouts;
