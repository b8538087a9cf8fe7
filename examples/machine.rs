//! A machine in SI units: its dimensionless groups, and a map over two of its quantities.
//!
//! cargo run --release --example machine -- FOLDER

use std::error::Error;
use std::path::PathBuf;

use tribochaos::machine::TEMPLATE;
use tribochaos::{Axis, Description, Experiment, ParameterMap, Quantity, Sampling, draw, run};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "outputs".to_owned()));
    let experiment = Experiment::builder()
        .machine(Description::from_toml(TEMPLATE)?)
        .axis(Axis::even("shaft_speed_amplitude", 100.0, 470.0, 40)?)
        .axis(Axis::even("radial_stiffness", 4e5, 1.2e6, 30)?)
        .set("x0", 0.0)?
        .sampling(Sampling {
            periods: 60,
            ..Sampling::default()
        })
        .build()?;
    println!(
        "gamma = {:.3} at the first point",
        experiment.design.point(0)[tribochaos::parameters::Parameter::Gamma]
    );
    let map = ParameterMap::try_from(run(&experiment)?)?;
    draw(&map, Quantity::ContactTime, folder.join("example-machine.png"))?;
    Ok(())
}
