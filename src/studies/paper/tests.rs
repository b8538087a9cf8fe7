use std::ops::ControlFlow;

use super::table::{Row, Value, markdown};
use super::*;
use crate::picture::layer::Layer;

fn compute(id: &str) -> Outcome {
    let carry_on = &mut || ControlFlow::Continue(());
    Figure::from_id(id)
        .unwrap()
        .compute(Effort::Quick, carry_on)
        .unwrap()
        .unwrap()
}

#[track_caller]
fn assert_number(row: &Row, expected: f64, tolerance: f64) {
    let Value::Number { value, .. } = row.computed else {
        panic!("{row:?}")
    };
    assert!((value - expected).abs() <= tolerance + 1e-9, "{row:?}");
}

#[test]
fn onsets_without_damping_are_found() {
    let outcome = compute("3.1");
    assert_number(&outcome.rows[0], 3.7775, 0.0025);
    assert_eq!((outcome.sheet.panels.len(), outcome.data.len()), (4, 4));
    assert_eq!(outcome.rows[0].paper, Value::number(3.78, 2));
}

#[test]
fn onsets_with_damping_are_found_and_the_paper_s_at_h1_1_is_not() {
    let rows = compute("3.2").rows;
    assert_number(&rows[0], 3.8025, 0.0025);
    assert_number(&rows[1], 3.8875, 0.0025);
    assert_number(&rows[2], 4.3025, 0.0025);
    assert!(rows[2].remark.contains("8 initial states"), "{}", rows[2].remark);
    assert_number(&rows[3], 0.0, 0.05);
}

#[test]
fn signs_and_thresholds_of_mel_nikov_s_function_agree() {
    let rows = compute("4.1").rows;
    assert_eq!(rows.len(), 9);
    for (row, expected) in rows.iter().skip(2).step_by(3).zip([3.3047, 3.6933, 3.9609]) {
        assert_number(row, expected, 6e-5);
    }
    assert!(
        rows.iter()
            .all(|row| ["agrees", "within"].contains(&row.difference().as_str()))
    );
}

#[test]
fn work_is_broken_off() {
    for figure in FIGURES {
        let outcome = figure.compute(Effort::Quick, &mut || ControlFlow::Break(()));
        assert!(outcome.unwrap().is_none(), "{}", figure.id);
    }
}

#[test]
fn rows_compare_what_can_be_compared() {
    let row = |paper, computed| Row::new("", paper, computed, "").difference();
    assert_eq!(
        row(Value::number(4.25, 2), Value::uncertain(4.3025, 0.0025, 4)),
        "+0.0525"
    );
    let between = Value::Between {
        low: 3.2,
        high: 3.81,
        digits: 2,
    };
    assert_eq!(row(between.clone(), Value::number(3.3, 4)), "within");
    assert_eq!(row(between, Value::number(4.0, 4)), "outside");
    assert_eq!(row(Value::words("a"), Value::words("b")), "differs");
    assert_eq!(row(Value::words("a"), Value::words("a")), "agrees");
    assert_eq!(row(Value::Nothing, Value::number(1.0, 1)), "-");
    assert_eq!(row(Value::number(1.0, 1), Value::Nothing), "not found");
    let row = Row::new(
        "onset",
        Value::number(3.78, 2),
        Value::uncertain(3.7775, 0.0025, 4),
        "a remark",
    );
    let table = markdown([("3.1", &row)].into_iter());
    assert!(
        table.ends_with("| 3.1 | onset | 3.78 | 3.7775 ± 0.0025 | -0.0025 | a remark |\n"),
        "{table}"
    );
}

#[test]
fn only_current_figures_count() {
    let folder = tempfile::tempdir().unwrap();
    let figure = Figure::from_id("4.1").unwrap();
    let files = Files::new(folder.path(), Effort::Quick);
    assert!(files.current(figure).is_none());
    let written = files.write(figure, &compute("4.1")).unwrap();
    assert!(written.iter().all(|file| file.is_file()));
    let kept = files.current(figure).unwrap();
    assert_eq!(kept.rows, compute("4.1").rows, "numbers survive their JSON form");
    assert!(Files::new(folder.path(), Effort::Full).current(figure).is_none());
    let (table, path) = files.write_table().unwrap();
    assert_eq!(table.lines().count(), 2 + 9);
    assert_eq!(std::fs::read_to_string(path).unwrap(), table);
    assert!(!files.is_of_other_effort(figure));
    assert!(Files::new(folder.path(), Effort::Full).is_of_other_effort(figure));
    // a file that is gone, cut short, or another one of the same length
    for name in ["figure-4.1.svg", "figure-4.1.png", "figure-4.1a.csv"] {
        let path = folder.path().join(name);
        let whole = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert!(files.current(figure).is_none(), "{name}");
        for other in [whole[..whole.len() / 2].to_vec(), vec![b' '; whole.len()]] {
            std::fs::write(&path, other).unwrap();
            assert!(files.current(figure).is_none(), "{name}");
        }
        std::fs::write(&path, whole).unwrap();
        assert!(files.current(figure).is_some(), "{name}");
    }
}

#[test]
fn heat_removes_chaos() {
    let Outcome { sheet, rows, data } = compute("5.1");
    assert_eq!((sheet.panels.len(), data.len(), rows.len()), (1, 1, 8));
    for row in rows.iter().step_by(2) {
        assert_eq!(row.difference(), "agrees", "{row:?}");
    }
    assert_number(&rows[5], -0.0808, 0.001);
    assert_number(&rows[7], -0.4474, 0.002);
}

#[test]
fn a_curve_s_number_has_one_colour_in_all_figures_and_legends_run_upward() {
    let mut colours = std::collections::BTreeMap::new();
    for id in ["5.1", "5.2", "5.3", "5.4"] {
        let sheet = compute(id).sheet;
        assert!(
            sheet.caption[1].starts_with("Curves are numbered as in the paper: 1 ("),
            "{id}"
        );
        let mut last = 0;
        for layer in &sheet.panels[0].layers {
            let (Layer::Curve { name, stroke, .. } | Layer::CurveKey { name, stroke }) = layer else {
                continue;
            };
            let Some((before, _)) = name.split_once(':') else {
                continue;
            };
            let number: u32 = before.rsplit(' ').next().unwrap().parse().unwrap();
            assert!(number >= last, "{id}: {name}");
            last = number;
            assert_eq!(
                *colours.entry(number).or_insert(stroke.colour),
                stroke.colour,
                "{id}: {name}"
            );
        }
    }
    assert_eq!(colours.len(), 4);
}

#[test]
fn without_heat_pressure_falls_to_nothing_and_wear_rises_to_1() {
    let rows = compute("5.2").rows;
    assert_eq!(rows.len(), 6);
    assert!(
        [&rows[0], &rows[3]].iter().all(|row| row.difference() == "agrees"),
        "{rows:?}"
    );
    assert_number(&rows[4], 0.8295, 0.0008);
    assert_number(&rows[5], 0.9483, 0.0009);
}

#[test]
fn heat_and_wear_end_the_contact() {
    let rows = compute("5.3").rows;
    assert_eq!(rows.len(), 6);
    for (row, expected, relative) in [
        (0, 72.0556, 1e-3),
        (1, 95.955, 1e-3),
        (2, 543.0, 0.02),
        (3, 65.840, 1e-3),
        (4, 92.321, 1e-3),
        (5, 296.0, 0.02),
    ] {
        assert_number(&rows[row], expected, relative * expected);
    }
    assert_eq!(rows[0].paper, Value::number(72.0, 0));
    assert!(
        rows[1].remark.starts_with("at tau = 6.73") && rows[4].remark.starts_with("at tau = 6.72"),
        "{rows:?}"
    );
}

#[test]
fn heat_multiplies_the_wear() {
    let rows = compute("5.4").rows;
    assert_eq!(rows.len(), 3);
    assert_number(&rows[0], 27.053, 0.027);
    assert_number(&rows[1], 30.206, 0.03);
    assert_number(&rows[2], 30.2, 0.1);
    assert!(rows[2].remark.starts_with("36.4 times"), "{:?}", rows[2]);
}
