//! In what two experiments differ.
//!
//! Owns the words for it; what identifies results, the experiment itself tells.

use toml::Value;

use super::Experiment;

/// Differences that are named, at most.
const MOST: usize = 3;

/// The values of this length that are named, at most: longer ones are not shown.
const LONGEST: usize = 60;

impl Experiment {
    /// In what the results of another experiment differ from those of this one, in words; None if they are the same.
    pub fn difference(&self, other: &Self) -> Option<String> {
        if self.has_results_of(other) {
            return None;
        }
        let parse = |experiment: &Self| experiment.to_toml().parse::<toml::Table>().unwrap_or_default();
        let mut differences = Vec::new();
        compare(
            "",
            Some(&parse(self).into()),
            Some(&parse(other).into()),
            &mut differences,
        );
        let more = differences.len().saturating_sub(MOST);
        differences.truncate(MOST);
        if more > 0 {
            differences.push(format!("{more} more"));
        }
        Some(differences.join("; "))
    }
}

fn compare(name: &str, there: Option<&Value>, here: Option<&Value>, differences: &mut Vec<String>) {
    match (there, here) {
        (there, here) if there == here => {}
        (Some(Value::Table(there)), Some(Value::Table(here))) => {
            let mut keys: Vec<&String> = there.keys().chain(here.keys()).collect();
            keys.sort();
            keys.dedup();
            for key in keys {
                let name = if name.is_empty() {
                    key.clone()
                } else {
                    format!("{name}.{key}")
                };
                compare(&name, there.get(key), here.get(key), differences);
            }
        }
        (Some(Value::Array(there)), Some(Value::Array(here))) if there.len() == here.len() => {
            for (index, (there, here)) in there.iter().zip(here).enumerate() {
                compare(&format!("{name}[{}]", index + 1), Some(there), Some(here), differences);
            }
        }
        (there, here) => differences.push(match (shown(there), shown(here)) {
            (Some(there), Some(here)) => format!("{name} is {there} there and {here} here"),
            _ => format!("{name} is not the same"),
        }),
    }
}

/// A value as it is shown; None if it is long.
fn shown(value: Option<&Value>) -> Option<String> {
    let text = value.map_or_else(|| "not set".to_owned(), ToString::to_string);
    (text.len() <= LONGEST && !text.contains('\n')).then_some(text)
}

#[cfg(test)]
mod tests {
    use crate::experiment::Request;

    #[test]
    fn what_differs_is_named_with_both_values() {
        let experiment = |changes: &[(&str, f64)], seed| {
            let mut request = Request::default();
            request
                .set
                .extend(changes.iter().map(|&(name, value)| (name.to_owned(), value)));
            request.sampling.seed = seed;
            request.resolve().unwrap()
        };
        let (one, other) = (experiment(&[("omega_0", 3.0)], 1), experiment(&[("omega_0", 2.5)], 4));
        assert_eq!(one.difference(&one), None);
        let text = one.difference(&other).unwrap();
        assert_eq!(
            text,
            "sampling.seed is 1 there and 4 here; set.omega_0 is 3.0 there and 2.5 here"
        );
        let of_axes = Request::over(Vec::new()).resolve().unwrap();
        let text = of_axes.difference(&experiment(&[], 1)).unwrap();
        assert!(text.starts_with("axes is not the same; "), "{text}");
    }
}
