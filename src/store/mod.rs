//! The Zarr store of a map: created before the run, written tile by tile, read back as a map.
//!
//! Decides neither what is computed nor in which order. In their order, each file knows those before it only:
//!
//! - `tile`: the rectangles of points that are written at once;
//! - `layout`: what other readers see of an array; `error`: what can be wrong with a store;
//! - `scales`: the arrays that lead to SI units;
//! - `map_store`: the store as a whole, created and opened;
//! - `values`: its values, written and read; `size`: its size on the disk;
//! - `write_lock`: the right to write it, which one process has at a time.

mod error;
mod layout;
mod map_store;
mod scales;
mod size;
#[cfg(test)]
mod tests;
mod tile;
mod values;
mod write_lock;

pub use self::error::StoreError;
pub use self::map_store::{MapStore, looks_like_a_store};
pub use self::size::{free_space, size_bytes};
pub use self::tile::{Tile, shape};
pub use self::write_lock::WriteLock;
