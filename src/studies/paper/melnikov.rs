//! Figure 4.1: Mel'nikov's function before and after its change of sign.
//!
//! Owns the panels' parameters and the paper's statements on them; M is [`crate::model::melnikov`]'s.

use super::table::{Row, Value};
use super::{Breaker, Data, Effort, Outcome, PaperError};
use crate::analysis::melnikov::{default_search, sampled};
use crate::model::melnikov::{Melnikov, threshold};
use crate::output::PROGRAM;
use crate::parameters::{Parameter, ParameterSet};
use crate::picture::sheet::{BESIDE, Sheet};
use crate::picture::{caption, charts};

/// A panel: damping, the amplitudes of the solid and of the broken curve, and the upper end of the paper's axis of M.
struct Panel {
    letter: &'static str,
    h1: f64,
    solid: f64,
    broken: f64,
    top: f64,
}

const PANELS: [Panel; 3] = [
    Panel {
        letter: "a",
        h1: 0.0,
        solid: 3.2,
        broken: 3.81,
        top: 22.0,
    },
    Panel {
        letter: "b",
        h1: 0.5,
        solid: 3.5,
        broken: 3.9,
        top: 25.0,
    },
    Panel {
        letter: "c",
        h1: 1.0,
        solid: 3.9,
        broken: 4.2,
        top: 30.0,
    },
];

/// The paper's axis of tau0.
const TIMES: [f64; 2] = [-4.0, 4.0];
/// Lower end of the axis of M. The paper's axis has no tick below zero; the broken curves reach about -1.
const BOTTOM: f64 = -2.0;

pub fn figure_4_1(effort: Effort, observer: &mut Breaker<'_>) -> Result<Option<Outcome>, PaperError> {
    let samples = match effort {
        Effort::Full => 1201,
        Effort::Quick => 161,
    };
    let search =
        default_search(&ParameterSet::default().into(), Parameter::ZetaK.into()).expect("every parameter has a range");
    let (mut panels, mut rows, mut data) = (Vec::new(), Vec::new(), Vec::new());
    for panel in &PANELS {
        let at = ParameterSet::default().with(Parameter::H1, panel.h1);
        let mut curves = Vec::new();
        let mut columns = Data {
            panel: panel.letter.to_owned(),
            columns: ["zeta_k", "tau_0", "melnikov"].map(str::to_owned).to_vec(),
            rows: Vec::new(),
        };
        for (zeta_k, changes) in [(panel.solid, false), (panel.broken, true)] {
            let point = at.with(Parameter::ZetaK, zeta_k);
            let curve = sampled(&point, TIMES[0], TIMES[1], samples)?;
            columns
                .rows
                .extend(curve.iter().map(|&[tau_0, m]| vec![zeta_k, tau_0, m]));
            curves.push((caption::assignment(Parameter::ZetaK, zeta_k), curve));
            let said = |changes: bool| Value::words(if changes { "changes sign" } else { "no change of sign" });
            rows.push(Row::new(
                &format!("M at h1 = {}, zeta_k = {zeta_k}", panel.h1),
                said(changes),
                said(Melnikov::new(&point)?.extremes().change_sign()),
                "",
            ));
            if observer().is_break() {
                return Ok(None);
            }
        }
        rows.push(Row::new(
            &format!("zeta_k from which M changes sign, h1 = {}", panel.h1),
            Value::Between {
                low: panel.solid,
                high: panel.broken,
                digits: 2,
            },
            match threshold(&at.into(), &search)?.value() {
                Some(value) => Value::number(value, 4),
                None => Value::Nothing,
            },
            "the paper shows one value before and one after",
        ));
        let title = format!("({}) {}", panel.letter, caption::assignment(Parameter::H1, panel.h1));
        panels.push(charts::melnikov(&title, &curves, Some([BOTTOM, panel.top])));
        data.push(columns);
    }
    let shown = [
        Parameter::ZetaK,
        Parameter::H1,
        Parameter::Epsilon,
        Parameter::Epsilon0,
        Parameter::X0,
        Parameter::Y0,
    ];
    let sheet = Sheet {
        panels,
        columns: 2,
        frame: BESIDE,
        caption: vec![
            caption::fixed(&ParameterSet::default().into(), &shown),
            format!("As figure 4.1 of Awrejcewicz and Pyryev (2006). {PROGRAM}."),
        ],
    };
    Ok(Some(Outcome { sheet, rows, data }))
}
