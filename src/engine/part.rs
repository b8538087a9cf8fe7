//! Fixed shares of an experiment, for processes that know nothing of each other.

use std::str::FromStr;

/// The share `number` of `of` equal ones. Units are dealt out one by one, so that slow regions of the design are spread over all shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    number: usize,
    of: usize,
}

impl Part {
    /// All units.
    pub const ALL: Self = Self { number: 1, of: 1 };

    /// The share `number` of `of`, counted from 1.
    ///
    /// # Errors
    /// If there is no such share.
    pub fn new(number: usize, of: usize) -> Result<Self, PartError> {
        if (1..=of).contains(&number) {
            Ok(Self { number, of })
        } else {
            Err(PartError::Outside { number, of })
        }
    }

    /// Whether this is the whole.
    pub fn is_all(self) -> bool {
        self.of == 1
    }

    /// The units of the share, of so many.
    pub fn units(self, count: usize) -> Vec<usize> {
        (self.number - 1..count).step_by(self.of).collect()
    }
}

/// `I/N`.
impl FromStr for Part {
    type Err = PartError;
    fn from_str(text: &str) -> Result<Self, PartError> {
        let numbers = text.split_once('/').and_then(|(number, of)| {
            let parse = |text: &str| text.trim().parse().ok();
            Some((parse(number)?, parse(of)?))
        });
        let (number, of) = numbers.ok_or_else(|| PartError::NoPart { text: text.to_owned() })?;
        Self::new(number, of)
    }
}

/// Why something is no share.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum PartError {
    #[error("`{text}` is no part: write I/N, such as 3/200 for the third of 200 parts")]
    NoPart { text: String },
    #[error("there is no part {number} of {of}: the parts are 1/{of} to {of}/{of}")]
    Outside { number: usize, of: usize },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_every_unit_once_and_are_equal_up_to_one() {
        for of in 1..7 {
            let parts: Vec<Part> = (1..=of).map(|number| Part::new(number, of).unwrap()).collect();
            let units: Vec<Vec<usize>> = parts.iter().map(|part| part.units(20)).collect();
            let mut all = units.concat();
            all.sort_unstable();
            assert_eq!(all, (0..20).collect::<Vec<_>>());
            assert!(
                units
                    .iter()
                    .all(|units| (20 / of..=20usize.div_ceil(of)).contains(&units.len()))
            );
        }
    }

    #[test]
    fn what_is_no_part_is_refused() {
        assert_eq!("3/200".parse(), Part::new(3, 200));
        for text in ["", "3", "a/b", "-1/3", "1/2/3"] {
            assert!(matches!(text.parse::<Part>(), Err(PartError::NoPart { .. })), "{text}");
        }
        for text in ["0/3", "4/3", "1/0"] {
            assert!(matches!(text.parse::<Part>(), Err(PartError::Outside { .. })), "{text}");
        }
    }
}
