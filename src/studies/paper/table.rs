//! The table of what the paper says and what the program gets.
//!
//! Owns how the two are compared and written; computes neither.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

/// A row of the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The quantity or property that is compared, with the parameters.
    pub what: String,
    /// What the paper says.
    pub paper: Value,
    /// What the program computed.
    pub computed: Value,
    /// A remark on the difference, or on how the computed value was found.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub remark: String,
}

/// A statement of the paper, or a result of the program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Value {
    /// A number with its uncertainty (0 where none is known) and the digits that are written after the point.
    Number {
        value: f64,
        uncertainty: f64,
        digits: usize,
    },
    /// Between two numbers.
    Between {
        low: f64,
        high: f64,
        digits: usize,
    },
    Words(String),
    /// The paper says nothing, or nothing was found.
    Nothing,
}

impl Value {
    pub fn number(value: f64, digits: usize) -> Self {
        Self::Number {
            value,
            uncertainty: 0.0,
            digits,
        }
    }

    pub fn uncertain(value: f64, uncertainty: f64, digits: usize) -> Self {
        Self::Number {
            value,
            uncertainty,
            digits,
        }
    }

    pub fn words(words: &str) -> Self {
        Self::Words(words.to_owned())
    }

    fn text(&self) -> String {
        match self {
            Self::Number {
                value,
                uncertainty: 0.0,
                digits,
            } => format!("{value:.digits$}"),
            Self::Number {
                value,
                uncertainty,
                digits,
            } => format!("{value:.digits$} ± {uncertainty:.digits$}"),
            Self::Between { low, high, digits } => format!("{low:.digits$} to {high:.digits$}"),
            Self::Words(words) => words.clone(),
            Self::Nothing => "-".to_owned(),
        }
    }
}

impl Row {
    pub fn new(what: &str, paper: Value, computed: Value, remark: &str) -> Self {
        Self {
            what: what.to_owned(),
            paper,
            computed,
            remark: remark.to_owned(),
        }
    }

    /// The computed value minus the paper's, or whether the two agree.
    pub fn difference(&self) -> String {
        match (&self.paper, &self.computed) {
            (
                Value::Number {
                    value: paper, digits, ..
                },
                Value::Number { value, digits: own, .. },
            ) => {
                format!("{:+.*}", *digits.max(own), value - paper)
            }
            (Value::Between { low, high, .. }, Value::Number { value, .. }) => {
                let within = (low..=high).contains(&value);
                if within { "within" } else { "outside" }.to_owned()
            }
            (Value::Nothing, _) => "-".to_owned(),
            (_, Value::Nothing) => "not found".to_owned(),
            (paper, computed) => if paper == computed { "agrees" } else { "differs" }.to_owned(),
        }
    }
}

/// The rows as a table in Markdown.
pub fn markdown<'a>(rows: impl Iterator<Item = (&'a str, &'a Row)>) -> String {
    let mut text = String::from(
        "| figure | what | paper | this program | difference | remark |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    for (figure, row) in rows {
        let _ = writeln!(
            text,
            "| {figure} | {} | {} | {} | {} | {} |",
            row.what,
            row.paper.text(),
            row.computed.text(),
            row.difference(),
            row.remark
        );
    }
    text
}
