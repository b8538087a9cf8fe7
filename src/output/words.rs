//! Numbers as people read them.

/// A number of bytes as text, in a suitable unit.
pub fn bytes(count: u64) -> String {
    const UNITS: [&str; 5] = ["bytes", "kB", "MB", "GB", "TB"];
    let rank = UNITS.len() - 1;
    let rank = (0..rank)
        .find(|&rank| (count as f64) < 1e3f64.powi(rank as i32 + 1))
        .unwrap_or(rank);
    let value = count as f64 / 1e3f64.powi(rank as i32);
    let digits = usize::from(rank > 0 && value < 100.0);
    format!("{value:.digits$} {}", UNITS[rank])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_shown_in_units_that_show_them() {
        for (count, text) in [
            (0, "0 bytes"),
            (999, "999 bytes"),
            (45_300, "45.3 kB"),
            (9_400_000, "9.4 MB"),
            (123_456_789_012, "123 GB"),
            (5_000_000_000_000_000, "5000 TB"),
        ] {
            assert_eq!(bytes(count), text);
        }
    }
}
