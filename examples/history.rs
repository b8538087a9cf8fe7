//! One point over time: pressure and wear until contact is lost.
//!
//! cargo run --release --example history

use std::error::Error;

use tribochaos::analysis::history;
use tribochaos::{Experiment, Preset};

fn main() -> Result<(), Box<dyn Error>> {
    let experiment = Experiment::builder()
        .preset(Preset::Paper)
        .set("zeta_k", 3.9)?
        .build()?;
    let history = history(&experiment.design.point(0), &experiment.settings.integration, 0..30, 16);
    for sample in history.samples.iter().step_by(32) {
        println!(
            "tau = {:7.3}  p = {:8.3}  u_w = {:7.3}",
            sample.tau, sample.pressure, sample.wear
        );
    }
    if let Some(tau) = history.contact_lost {
        println!("contact is lost at tau = {tau:.3}");
    }
    Ok(())
}
