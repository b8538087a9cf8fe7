//! Results on disk as Zarr: created before the run, written unit by unit, read back.
//!
//! Decides neither what is computed nor in which order. Each file uses only those before it in this list:
//!
//! - `units`: the ranges of points that are written at once;
//! - `error`: what can be wrong with a store; `checksum`: what notices changes;
//! - `sync`: files that are on the disk when a function returns; `root`: the store's folder while it is used;
//! - `mark`: what tells that a unit is finished; `group`: what the store holds, and checksums of its small files;
//! - `lock`: what keeps processes apart;
//! - `layout`: what other readers see of an array; `chunk`: an array's values as files;
//! - `store`: the store as a whole, created, opened and mended;
//! - `values`: its values, written, checked and read; `size`: its size on the disk; `slice`: maps out of it;
//! - `wanted`: a store before a run.

mod checksum;
mod chunk;
mod error;
mod group;
mod layout;
mod lock;
mod mark;
mod root;
mod size;
mod slice;
#[expect(clippy::module_inception, reason = "the type is the module's main one")]
mod store;
mod sync;
#[cfg(test)]
mod tests;
mod units;
mod values;
mod wanted;

pub use self::error::StoreError;
pub use self::lock::{Lock, Use};
pub use self::mark::Mark;
pub use self::size::{free_space, point_bytes, size_bytes};
pub use self::slice::SliceError;
pub use self::store::{Store, looks_like_a_store};
pub use self::sync::clean_beside;
pub use self::units::Units;
pub use self::wanted::{Opened, Wanted, check_replaceable};
