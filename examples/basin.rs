//! Basins of attraction: which initial states lead to chaos.
//!
//! cargo run --release --example basin -- FOLDER

use std::error::Error;
use std::path::PathBuf;

use tribochaos::{Axis, Experiment, ParameterMap, Quantity, draw, run};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "outputs".to_owned()));
    let experiment = Experiment::builder()
        .axis(Axis::even("x0", -2.0, 2.0, 100)?)
        .axis(Axis::even("y0", -2.0, 2.0, 100)?)
        .set("zeta_k", 3.85)?
        .build()?;
    let map = ParameterMap::try_from(run(&experiment)?)?;
    draw(&map, Quantity::Class, folder.join("example-basin.png"))?;
    Ok(())
}
