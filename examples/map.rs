//! A chaos-threshold map: computed, drawn, and kept in a store.
//!
//! cargo run --release --example map -- FOLDER

use std::error::Error;
use std::ops::ControlFlow;
use std::path::PathBuf;

use tribochaos::{Axis, Class, Experiment, ParameterMap, Quantity, Store, draw, run_into};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "outputs".to_owned()));
    let experiment = Experiment::builder()
        .axis(Axis::even("zeta_k", 3.0, 5.0, 120)?)
        .axis(Axis::even("h1", 0.0, 1.5, 80)?)
        .build()?;

    // a store keeps what is finished, whatever happens; opened again, it would be completed
    let mut store = Store::create(
        &folder.join("example.zarr"),
        &experiment,
        &Quantity::of_map(&experiment),
        960,
    )?
    .writing(None)?;
    run_into(&experiment, &mut store, &mut |_| ControlFlow::Continue(()))?;

    let map = ParameterMap::try_from(store.read()?)?;
    let chaotic = (0..experiment.design.len()).filter(|&point| map.class(point) == Some(Class::Chaotic));
    println!("{} of {} points are chaotic", chaotic.count(), experiment.design.len());
    draw(&map, Quantity::Lyapunov, folder.join("example-map.png"))?;
    Ok(())
}
