//! Error bars mean what they say, for every estimator, on processes whose answers are known.
#![allow(clippy::unwrap_used)]

use zimm::core::noise::{Domain, Noise};
use zimm::prelude::*;

/// Independent normal numbers.
struct Random {
    seed: u64,
    drawn: u32,
}

impl Random {
    fn new(seed: u64) -> Self {
        Self { seed, drawn: 0 }
    }

    fn normal3(&mut self) -> DVec3 {
        self.drawn += 1;
        Noise::new(self.seed, 0)
            .site(self.drawn)
            .normal3(Domain::user(0))
    }
}

/// Three independent Ornstein-Uhlenbeck processes of unit variance at equal times, C(k) = phi^k, from the stationary
/// state.
struct Process {
    phi: f64,
    now: DVec3,
    random: Random,
}

impl Process {
    fn new(phi: f64, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let now = random.normal3();
        Self { phi, now, random }
    }

    fn next(&mut self) -> DVec3 {
        let before = self.now;
        self.now = self.phi * before + (1.0 - self.phi * self.phi).sqrt() * self.random.normal3();
        before
    }
}

/// How often repeated runs with a known error are within one and 1.96 of their errors of the truth.
#[derive(Default)]
struct Coverage {
    runs: f64,
    known: f64,
    one: f64,
    two: f64,
    values: f64,
    squares: f64,
    errors: f64,
}

impl Coverage {
    fn take(&mut self, mean: Mean, exact: f64) {
        self.runs += 1.0;
        self.values += mean.value - exact;
        self.squares += (mean.value - exact).powi(2);
        if let Some(error) = mean.standard_error() {
            let off = (mean.value - exact).abs();
            self.known += 1.0;
            self.one += f64::from(off < error);
            self.two += f64::from(off < 1.96 * error);
            self.errors += error * error;
        }
    }

    /// Asserts that four errors of five are known, cover what they should, are as large as the scatter of the runs,
    /// and that the mean of all runs is right.
    ///
    /// Nominal shares are 68.3 and 95.0 %. Bounds are 4 binomial sigma, and below them another 2 % for what errors
    /// from 16 to 128 blocks cost by design (Student's t takes 0.3 to 1.5 %). The scatter of n runs is known to 1 /
    /// sqrt(2 n): bounds are 4 of it and 4 % for the design. The mean of n runs has 1 / sqrt(n) of the scatter: bound
    /// 4 of it.
    fn assert_honest(&self, name: &str) {
        let (one, two) = (self.one / self.known, self.two / self.known);
        let scatter = (self.squares / self.runs).sqrt();
        let error = (self.errors / self.known).sqrt() / scatter;
        let bias = self.values / self.runs / scatter;
        println!(
            "{name}: known {:.3}, 68 %: {one:.3}, 95 %: {two:.3}, error / scatter {error:.3}, bias / scatter {bias:.3}",
            self.known / self.runs,
        );
        assert!(self.known / self.runs > 0.8, "{name}: plateaus");
        for (found, nominal) in [(one, 0.683_f64), (two, 0.95)] {
            let sigma = (nominal * (1.0 - nominal) / self.known).sqrt();
            assert!(found > nominal - 4.0 * sigma - 0.02, "{name}: {found}");
            assert!(found < nominal + 4.0 * sigma, "{name}: {found}");
        }
        let bound = 4.0 / (2.0 * self.runs).sqrt() + 0.04;
        assert!((error - 1.0).abs() < bound, "{name}: {error}");
        assert!(bias.abs() < 4.0 / self.runs.sqrt(), "{name}: {bias}");
    }
}

/// Everything that an Ornstein-Uhlenbeck process of three components and unit variance, C(k) = phi^k, is asked for:
/// `[mean, ratio, C(0), C(4), C(24), integral, relaxation time, D, displacement, steady mean, sliding mean, viscosity,
/// G', G'']` of runs of so many samples.
fn ornstein_uhlenbeck(phi: f64, samples: u64, runs: u64) -> [Coverage; 14] {
    let rate = -phi.ln();
    let (sum, late) = ((1.0 + phi) / (1.0 - phi), 10.0 / rate);
    // Beyond lag 16 the correlation is that of means of two samples.
    let far = phi.powi(24) * (2.0 + phi + 1.0 / phi) / 4.0;
    // The stress xx = -yy = y, xz = x has S : S = 2 (x^2 + y^2) = 4 at lag zero; V / 10 kT = 2.5 makes it 10.
    let frequency = 0.3 * rate;
    let moduli = |stress: &GreenKubo| stress.moduli(&[frequency], late).unwrap()[0];
    let under = 1.0 + (frequency / rate).powi(2);
    // Positions are sums of 0.3 x.
    let squared =
        |lag: f64| 0.27 * (lag * sum - 2.0 * phi * (1.0 - phi.powf(lag)) / (1.0 - phi).powi(2));
    let lags = [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
    let slope: f64 = lags
        .iter()
        .map(|lag| (lag - 5.0) * squared(*lag) / 28.0)
        .sum();
    let exact = [
        0.0,
        2.0,
        3.0,
        3.0 * phi.powi(4),
        3.0 * far,
        1.5 * sum,
        1.0 / rate,
        slope / 6.0,
        squared(3.0),
        0.0,
        0.0,
        5.0 * sum,
        10.0 * (frequency / rate).powi(2) / under,
        10.0 * (frequency / rate) / under,
    ];
    let mut coverage: [Coverage; 14] = Default::default();
    for seed in 0..runs {
        let mut process = Process::new(phi, seed);
        let (mut mean, mut ratio) = (BlockAverage::new(), RatioAverage::new());
        let mut correlation = Autocorrelation::new(1.0).unwrap();
        let mut displacement = MeanSquareDisplacement::new(1.0, 2..=8).unwrap();
        let (mut steady, mut sliding) = (
            SteadyAverage::new(),
            SlidingAverage::new(samples / 2).unwrap(),
        );
        let mut green_kubo = GreenKubo::new(1.0, 50.0, 2.0).unwrap();
        let mut r = DVec3::ZERO;
        for _ in 0..samples {
            let x = process.next();
            mean.push(x.x);
            ratio.push([2.0 * (6.0 + x.y) + x.x, 6.0 + x.y]);
            correlation.push(x);
            displacement.push(vec![r]);
            r += 0.3 * x;
            steady.push(x.z);
            sliding.push(x.z);
            let columns = [
                DVec3::new(x.y, 0.0, x.x),
                DVec3::new(0.0, -x.y, 0.0),
                DVec3::X * x.x,
            ];
            green_kubo.push(DMat3::from_cols(columns[0], columns[1], columns[2]));
        }
        let decay = correlation.estimate().unwrap();
        let at = |time: f64| decay.times.iter().position(|&t| t == time).unwrap();
        let diffusion = displacement.estimate().unwrap();
        let moduli = moduli(&green_kubo);
        let found = [
            mean.estimate().unwrap(),
            ratio.estimate().unwrap(),
            decay.correlation[0],
            decay.correlation[at(4.0)],
            decay.correlation[at(24.0)],
            correlation.integral(late).unwrap(),
            correlation.relaxation_time(0.0..=4.0).unwrap(),
            diffusion.coefficient,
            diffusion.displacement[2],
            steady.estimate().unwrap(),
            sliding.estimate().unwrap(),
            green_kubo.viscosity(late).unwrap(),
            moduli.storage,
            moduli.loss,
        ];
        for ((coverage, mean), exact) in coverage.iter_mut().zip(found).zip(exact) {
            coverage.take(mean, exact);
        }
    }
    coverage
}

const NAMES: [&str; 14] = [
    "mean",
    "ratio",
    "C(0)",
    "C(4)",
    "C(24)",
    "integral",
    "relaxation time",
    "D",
    "displacement",
    "steady mean",
    "sliding mean",
    "viscosity",
    "G'",
    "G''",
];

/// Seeds 0..400, 8192 samples, 910 independent ones. An error wrong by 18 % is caught (4 sigma of the scatter and the
/// design). The mean of all runs is known to 0.2 % for the square, 0.5 % for the integral, viscosity and moduli, 0.4 %
/// for D: a value wrong by 1 to 2 % is caught.
#[test]
fn limit_errors_of_an_autoregressive_process_are_honest() {
    for (coverage, name) in ornstein_uhlenbeck(0.8, 8192, 400).iter().zip(NAMES) {
        coverage.assert_honest(name);
    }
}

/// As close in time as samples of a process that is continuous: 20 to a relaxation time. Seeds 0..100, 32 768 samples,
/// 840 independent ones. An error wrong by a third is caught, a value wrong by 2 to 5 %.
#[test]
fn limit_errors_of_an_ornstein_uhlenbeck_process_are_honest() {
    for (coverage, name) in ornstein_uhlenbeck(0.95, 32_768, 100).iter().zip(NAMES) {
        coverage.assert_honest(name);
    }
}

/// A transient of five standard deviations that lasts for 200 of 8192 samples shifts the mean of all samples by 0.122,
/// four errors (0.033). Seeds 0..1000; what is left of it must not show: bound 4 / sqrt(1000) = 13 % of an error,
/// 0.004.
#[test]
fn limit_a_transient_is_left_out() {
    let mut coverage = Coverage::default();
    for seed in 0..1000 {
        let (mut process, mut average) = (Process::new(0.8, seed), SteadyAverage::new());
        for k in 0..8192 {
            average.push(process.next().x + 5.0 * (-f64::from(k) / 200.0).exp());
        }
        coverage.take(average.estimate().unwrap(), 0.0);
    }
    coverage.assert_honest("after a transient");
}

/// Runs that stop when they are told to, at an error of 1 %, which takes 3 / 0.05^2 = 1200 samples. Seeds 0..1000.
/// Errors that are estimated too small stop some runs early: by less than what is allowed for the design. Runs are
/// longer than they have to be by what is asked for too much, less than twice.
#[test]
fn limit_a_run_is_as_long_as_it_has_to_be() {
    let (mut coverage, mut length) = (Coverage::default(), 0.0);
    for seed in 0..1000 {
        let (mut process, mut average) = (Process::new(0.5, seed), BlockAverage::new());
        let mut more = 200;
        while more > 0 {
            (0..more).for_each(|_| average.push(5.0 + process.next().x));
            more = average
                .estimate()
                .unwrap()
                .more_samples(average.samples(), 0.01);
        }
        length += average.samples() as f64 / 1000.0;
        let mean = average.estimate().unwrap();
        assert!(mean.standard_error().unwrap() <= 0.01 * mean.value);
        coverage.take(mean, 5.0);
    }
    println!("{length} samples");
    assert!(length > 1200.0 && length < 2400.0, "{length}");
    // Runs are of different lengths, so their scatter is that of none of them; shares are what count.
    coverage.assert_honest("when told to stop");
}
