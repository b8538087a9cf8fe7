//! Results of a machine in SI units: as objects, as text after dimensionless numbers, and as warnings.
//!
//! Owns the names and words; the scales are the library's.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use crate::backend::Contact;
use crate::design::Fixed;
use crate::machine::units::si;
use crate::machine::{Machine, Scale, SiQuantity};
use crate::measure::Measurement;

/// The SI value of a dimensionless number, to print after it: ` (35.06 MPa)`; empty without a machine.
pub fn behind(at: &Fixed, value: f64, scale: Scale) -> String {
    match at.machine() {
        Some(machine) if value.is_finite() => {
            format!(" ({})", si(machine.scales().of(scale) * value, scale.unit()))
        }
        _ => String::new(),
    }
}

/// Prints the results of the contact; the text `held` is printed if contact was not lost.
pub fn print_contact(at: &Fixed, contact: &Contact, held: &str) {
    let behind = |value: f64, scale: Scale| behind(at, value, scale);
    match contact.lost {
        Some(time) => print_line!(
            "contact             lost at tau = {time:.4}{}",
            behind(time, Scale::Time)
        ),
        None => print_line!("contact             {held}"),
    }
    print_line!(
        "peak pressure       {:.5}{} at tau = {:.4}{}",
        contact.peak_pressure,
        behind(contact.peak_pressure, Scale::Pressure),
        contact.peak_pressure_time,
        behind(contact.peak_pressure_time, Scale::Time)
    );
    let wear = contact.final_wear;
    print_line!("final wear          {wear:.5}{}", behind(wear, Scale::Length));
    let temperature = contact.peak_temperature;
    print_line!(
        "peak temperature    {temperature:.3}{}  (of the surface{})",
        behind(temperature, Scale::Temperature),
        if at.machine().is_some() {
            ", above the ambient one"
        } else {
            ""
        }
    );
}

/// The results of the contact; null without a machine.
pub fn contact(at: &Fixed, contact: &Contact) -> Value {
    let Some(machine) = at.machine() else {
        return Value::Null;
    };
    let scales = machine.scales();
    json!({
        "contact_time_s": contact.lost.map(|time| scales.time * time),
        "peak_pressure_pa": scales.pressure * contact.peak_pressure,
        "peak_pressure_time_s": scales.time * contact.peak_pressure_time,
        "final_wear_m": scales.length * contact.final_wear,
        // above the ambient temperature
        "peak_temperature_rise_k": scales.temperature * contact.peak_temperature,
    })
}

/// As [`contact`], with the exponent and the frequencies of the drive and of the motion.
pub fn measurement(at: &Fixed, m: &Measurement) -> Value {
    let mut object = contact(at, &m.contact);
    if let Some(machine) = at.machine() {
        let frequency = forcing_frequency(machine);
        object["lyapunov_per_s"] = (m.lyapunov / machine.scales().time).into();
        object["forcing_frequency_hz"] = frequency.into();
        object["motion_frequency_hz"] = m.period.map(|period| frequency / f64::from(period)).into();
    }
    object
}

/// Warnings, each a sentence, of results that the material does not survive or for which the model does not hold. `angle` is the
/// greatest magnitude of x.
pub fn beyond(at: &Fixed, contact: &Contact, angle: f64) -> Vec<String> {
    let Some(machine) = at.machine() else {
        return Vec::new();
    };
    let beyond = machine.beyond(contact.peak_pressure, contact.peak_temperature, angle);
    beyond
        .iter()
        .map(|beyond| format!("beyond the model's limits: {beyond}"))
        .collect()
}

/// The frequency of a motion whose period is given in forcing periods, to print after it: ` (9.39 Hz)`; empty without a machine.
pub fn frequency_behind(at: &Fixed, period: Option<u32>) -> String {
    match (at.machine(), period) {
        (Some(machine), Some(period)) => format!(" ({})", si(forcing_frequency(machine) / f64::from(period), "Hz")),
        _ => String::new(),
    }
}

/// The frequency of the drive, in Hz.
fn forcing_frequency(machine: &Machine) -> f64 {
    machine.value(SiQuantity::ShaftSpeedFrequency) / TAU
}
