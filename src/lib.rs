pub mod experiment;
pub mod grid;
pub mod map;
pub mod measurement;
pub mod output;
pub mod parameters;
