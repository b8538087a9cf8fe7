//! Where chaos begins as the drive grows, from two initial states.
//!
//! cargo run --release --example onset

use std::error::Error;
use std::ops::ControlFlow;

use tribochaos::analysis::onset::{Definition, Scan, Way, fine_axis};
use tribochaos::engine::choice::choose;
use tribochaos::{Axis, Experiment};

fn main() -> Result<(), Box<dyn Error>> {
    let axis = Axis::even("zeta_k", 3.6, 4.0, 2)?;
    let experiment = Experiment::builder().axis(axis.clone()).set("h1", 0.5)?.build()?;
    let mut backends = choose(&experiment)?.backends;
    let scan = Scan {
        definition: &Definition::new(&experiment.settings),
        at: &experiment.design.fixed,
        axis: fine_axis(&axis, 0.0025),
        starts: &[[0.1, 0.0], [1.0, 0.0]],
    };
    let scanned = scan.first(Way::Up, &mut backends, &mut |_| ControlFlow::Continue(()))?;
    match scanned.and_then(|scanned| scanned.found) {
        Some(found) => println!("chaos begins at zeta_k = {} +- 0.0025", found.value),
        None => println!("no chaos"),
    }
    Ok(())
}
