//! Shares of counted points.

/// A part of some points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Points that count.
    pub of: u64,
    /// All points.
    pub all: u64,
}

/// Standard errors on either side of a 95 % interval.
const CONFIDENCE: f64 = 1.959_963_984_540_054;

impl Share {
    /// Adds a point, which counts or not.
    pub fn add(&mut self, counts: bool) {
        self.of += u64::from(counts);
        self.all += 1;
    }

    /// The share; NaN without points.
    pub fn value(self) -> f64 {
        self.of as f64 / self.all as f64
    }

    /// Wilson's 95 % interval of the share (1927), if the points were drawn at random; from 0 to 1 without points.
    pub fn interval(self) -> [f64; 2] {
        if self.all == 0 {
            return [0.0, 1.0];
        }
        let (share, all, z2) = (self.value(), self.all as f64, CONFIDENCE * CONFIDENCE);
        let middle = share + z2 / (2.0 * all);
        let half = CONFIDENCE * (share * (1.0 - share) / all + z2 / (4.0 * all * all)).sqrt();
        // the ends are exact where all or none count
        let low = if self.of == 0 { 0.0 } else { middle - half };
        let high = if self.of == self.all {
            1.0 + z2 / all
        } else {
            middle + half
        };
        [low, high].map(|end| (end / (1.0 + z2 / all)).clamp(0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newcombe (1998), Table I, method 3.
    #[test]
    fn intervals_are_the_published_ones() {
        for (of, all, expected) in [
            (81, 263, [0.2553, 0.3662]),
            (15, 148, [0.0624, 0.1605]),
            (0, 20, [0.0, 0.1611]),
            (1, 29, [0.0061, 0.1718]),
        ] {
            let interval = Share { of, all }.interval();
            for (found, expected) in interval.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-4, "{of} of {all}: {interval:?}");
            }
        }
        assert_eq!(Share { of: 20, all: 20 }.interval()[1], 1.0);
        assert_eq!(Share::default().interval(), [0.0, 1.0]);
    }
}
