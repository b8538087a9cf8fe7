//! The box-counting dimension of a border.
//!
//! Owns the fit; the boxes are counted by the lattice.

/// An estimate of the dimension of a border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimension {
    /// The finest level of the fit, which begins at level 0.
    pub level: usize,
    /// The slope of log2 N over the level, where N is the number of boxes through which the border passes. Boxes of a level have half the
    /// side of those of the level below it.
    pub value: f64,
    /// The standard error of the slope. It tells how straight the line is, not what refinement has missed.
    pub error: f64,
}

/// Levels that are left out of the fit. The finest boxes are known by their corners alone: a border that bends within
/// a box is not seen there, while it is seen in the larger boxes that hold it.
const LEFT_OUT: usize = 2;

/// Least number of levels of a fit.
const LEAST: usize = 3;

/// The dimension from the number of boxes of each level; None from fewer than five levels, or without a border.
pub fn dimension(boxes: &[usize]) -> Option<Dimension> {
    if boxes.len() < LEAST + LEFT_OUT || boxes.contains(&0) {
        return None;
    }
    let boxes = &boxes[..boxes.len() - LEFT_OUT];
    let count = boxes.len() as f64;
    let logarithms: Vec<f64> = boxes.iter().map(|&boxes| (boxes as f64).log2()).collect();
    let middle = 0.5 * (count - 1.0);
    let mean = logarithms.iter().sum::<f64>() / count;
    let levels = || (0..boxes.len()).map(|level| level as f64 - middle);
    let spread: f64 = levels().map(|level| level * level).sum();
    let value = levels()
        .zip(&logarithms)
        .map(|(level, log)| level * (log - mean))
        .sum::<f64>()
        / spread;
    let residual = |(level, log): (f64, &f64)| log - mean - value * level;
    let squares: f64 = levels().zip(&logarithms).map(|pair| residual(pair).powi(2)).sum();
    Some(Dimension {
        level: boxes.len() - 1,
        value,
        error: (squares / (count - 2.0) / spread).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_have_their_exponents() {
        let exact = dimension(&[8, 16, 32, 64, 100, 150]).unwrap();
        assert!((exact.value - 1.0).abs() < 1e-12 && exact.error < 1e-12, "{exact:?}");
        assert_eq!(exact.level, 3);
        let bent = dimension(&[2, 4, 16, 16, 16]).unwrap();
        // log2 N = 1, 2, 4: slope 3/2, residuals 1/6, -1/3, 1/6
        assert!((bent.value - 1.5).abs() < 1e-12);
        assert!((bent.error - (1.0f64 / 6.0 / 2.0).sqrt()).abs() < 1e-12, "{bent:?}");
        assert_eq!(dimension(&[4, 8, 16, 32]), None);
        assert_eq!(dimension(&[0; 6]), None);
    }

    /// Cantor's set has the dimension ln 2 / ln 3; the number of its boxes oscillates about that power.
    #[test]
    fn a_fractal_has_its_dimension() {
        let mut ends = vec![0.0];
        for generation in 1..=14 {
            let step = 2.0 / 3f64.powi(generation);
            ends.extend(ends.clone().into_iter().map(|end| end + step));
        }
        let boxes = |level: i32| {
            let side = 0.25 / f64::from(level).exp2();
            let boxes: std::collections::BTreeSet<u64> = ends.iter().map(|end| (end / side) as u64).collect();
            boxes.len()
        };
        let boxes: Vec<usize> = (0..12).map(boxes).collect();
        let fitted = dimension(&boxes).unwrap();
        assert!(
            (fitted.value - 2f64.ln() / 3f64.ln()).abs() < 0.04 && fitted.error < 0.02,
            "{boxes:?}: {fitted:?}"
        );
    }
}
