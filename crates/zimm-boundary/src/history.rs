//! How a flow goes on in time.

mod cessation;
mod oscillation;
mod start_up;
mod steady;
mod step_strain;
mod then;

pub use cessation::Cessation;
pub use oscillation::Oscillation;
pub use start_up::StartUp;
pub use steady::Steady;
pub use step_strain::StepStrain;
pub use then::Then;

/// A flow of fixed shape K as a function of time: kappa(t) = rate(t) K carries by exp(strain(t) K).
///
/// What the strain measures is said by the flow: displacement along x per length along y in shear, the logarithm of
/// the stretch (Hencky strain) in extension. Since the shape is fixed, a flow that stops, starts again or changes its
/// rate keeps its lattice.
///
/// An implementation guarantees that the strain is the integral of the rate, in closed form, that both are finite at
/// finite times, and that they are pure functions: time may be asked for in any order. A rate that jumps has the value
/// after the jump at the time of the jump.
///
/// ```
/// use zimm_boundary::FlowHistory;
///
/// /// A rate that grows in proportion to time.
/// #[derive(Clone)]
/// struct Ramp {
///     acceleration: f64,
/// }
///
/// impl FlowHistory for Ramp {
///     fn strain(&self, time: f64) -> f64 {
///         0.5 * self.acceleration * time * time
///     }
///
///     fn rate(&self, time: f64) -> f64 {
///         self.acceleration * time
///     }
/// }
///
/// let ramp = Ramp { acceleration: 0.5 };
/// assert_eq!((ramp.strain(2.0), ramp.rate(2.0)), (1.0, 1.0));
/// ```
pub trait FlowHistory: Clone + Send + Sync {
    /// The strain at a time, from the state in which the cell is as its constructor tells.
    fn strain(&self, time: f64) -> f64;

    /// The rate at a time, in inverse time.
    fn rate(&self, time: f64) -> f64;
}

/// No flow: the null history.
impl FlowHistory for () {
    fn strain(&self, _: f64) -> f64 {
        0.0
    }

    fn rate(&self, _: f64) -> f64 {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zimm_core::ParameterError;

    /// The integral of the rate by Simpson's rule, jumps of the rate only at the ends of panels.
    fn integral(history: &impl FlowHistory, from: f64, to: f64) -> f64 {
        let panels = 64;
        let h = (to - from) / f64::from(panels);
        let mut sum = 0.0;
        for k in 0..panels {
            let a = from + f64::from(k) * h;
            // Rates are continuous from the right; the left limit at the end of a panel is asked for just before it.
            let end = a + h * (1.0 - 1e-12);
            let ends = history.rate(a) + history.rate(end);
            sum += h / 6.0 * (ends + 4.0 * history.rate(a + 0.5 * h));
        }
        sum
    }

    /// Simpson's error for the oscillation is (h omega)^4 / 2880 = 2e-8 of the amplitude; an error of the rate by 1 %
    /// would show at 1e-2.
    #[test]
    fn law_strain_is_the_integral_of_the_rate() -> Result<(), ParameterError> {
        fn check(history: &impl FlowHistory) {
            for (from, to) in [(0.0, 1.0), (-2.0, 0.0), (1.0, 3.0), (0.25, 0.75)] {
                let change = history.strain(to) - history.strain(from);
                let error = change - integral(history, from, to);
                assert!(error.abs() < 1e-7, "from {from} to {to}: {error:e}");
            }
        }
        check(&());
        check(&Steady::new(-0.7)?);
        check(&StartUp::new(1.3, 1.0)?);
        check(&Cessation::new(1.3, 1.0)?);
        check(&Oscillation::new(0.8, 2.5)?);
        let backwards = Then::new(Steady::new(1.3)?, 1.0, Steady::new(-0.4)?)?;
        check(&backwards);
        check(&Then::new(backwards, 0.5, ())?);
        Ok(())
    }

    #[test]
    fn limit_values_at_and_around_jumps() -> Result<(), ParameterError> {
        let before = 2.0_f64.next_down();
        let start = StartUp::new(0.5, 2.0)?;
        assert_eq!((start.rate(before), start.rate(2.0)), (0.0, 0.5));
        assert_eq!((start.strain(2.0), start.strain(6.0)), (0.0, 2.0));
        let stop = Cessation::new(0.5, 2.0)?;
        assert_eq!((stop.rate(before), stop.rate(2.0)), (0.5, 0.0));
        assert_eq!((stop.strain(1.0), stop.strain(6.0)), (0.5, 1.0));
        let step = StepStrain::new(0.5, 2.0)?;
        assert_eq!(step.strain(2.0), 0.0);
        assert_eq!(step.strain(2.0_f64.next_up()), 0.5);
        assert_eq!((step.rate(2.0), step.rate(3.0)), (0.0, 0.0));
        let change = Then::new(Steady::new(0.5)?, 2.0, Steady::new(3.0)?)?;
        assert_eq!((change.rate(before), change.rate(2.0)), (0.5, 3.0));
        assert_eq!((change.strain(2.0), change.strain(3.0)), (1.0, 4.0));
        let wave = Oscillation::new(0.5, 2.0)?;
        assert_eq!((wave.strain(0.0), wave.rate(0.0)), (0.0, 1.0));
        Ok(())
    }

    #[test]
    fn extreme_parameters_are_refused_by_name() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(Then::new((), x, ()).unwrap_err().name, "time of change");
            assert_eq!(Steady::new(x).unwrap_err().name, "rate");
            assert_eq!(StartUp::new(x, 0.0).unwrap_err().name, "rate");
            assert_eq!(StartUp::new(1.0, x).unwrap_err().name, "time of start");
            assert_eq!(Cessation::new(x, 0.0).unwrap_err().name, "rate");
            assert_eq!(Cessation::new(1.0, x).unwrap_err().name, "time of end");
            assert_eq!(StepStrain::new(x, 0.0).unwrap_err().name, "strain");
            assert_eq!(StepStrain::new(1.0, x).unwrap_err().name, "time of step");
            let amplitude = Oscillation::new(x, 1.0).unwrap_err();
            assert_eq!(amplitude.name, "strain amplitude");
            let frequency = Oscillation::new(1.0, x).unwrap_err();
            assert_eq!(frequency.name, "angular frequency");
        }
        for x in [0.0, -1.0] {
            assert_eq!(Oscillation::new(1.0, x).unwrap_err().found, x);
            assert!(Steady::new(x).is_ok());
        }
        // Products that overflow are refused as well.
        let frozen = Cessation::new(1e200, 1e200).unwrap_err();
        assert_eq!(frozen.name, "strain at the end");
        let long = Steady::new(1e200).unwrap();
        let change = Then::new(long, 1e200, ()).unwrap_err();
        assert_eq!(change.name, "strain at the change");
        let peak = Oscillation::new(1e200, 1e200).unwrap_err();
        assert_eq!(peak.name, "largest rate");
    }

    #[test]
    fn extreme_very_long_times_stay_bounded() -> Result<(), ParameterError> {
        let wave = Oscillation::new(0.5, 3.0)?;
        let stop = Cessation::new(0.5, 2.0)?;
        for time in [1e9, 1e15, 1e300, f64::MAX / 4.0] {
            assert!(wave.strain(time).abs() <= 0.5);
            assert!(wave.rate(time).abs() <= 1.5);
            assert_eq!(stop.strain(time), 1.0);
        }
        Ok(())
    }
}
