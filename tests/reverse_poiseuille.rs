//! Reverse Poiseuille flow as a rheometer: simple fluids against theory and other rheometers, the melts of Fedosov,
//! Karniadakis and Caswell (2010), whose athermal equation of state is in `equation_of_state.rs`.
#![allow(clippy::unwrap_used)]

mod fedosov;
mod scene;

use fedosov::{Shown, flow, melt, show};
use scene::{fluid, pairs, run};
use std::ops::Range;
use zimm::prelude::*;

/// The fluid of Groot and Warren in a channel of height 10, 1080 particles, f = 0.05: rates up to 0.44.
fn groot_warren(time: f64, seed: u64) -> Shown {
    let dt = 0.04;
    let space = PeriodicBox::brick(DVec3::new(6.0, 10.0, 6.0)).unwrap();
    let mut system = fluid(space, 3.0, Clock::new(dt, 1.0, seed).unwrap());
    let drive = ReversePoiseuille::new(0.05, 0, 1).unwrap();
    let mut field = (pairs(Dpd::new(25.0, 4.5).unwrap()), drive);
    let mut stepper = GrootWarren::new(0.65).unwrap();
    let steps = (1500, (time / dt) as u32, 5);
    flow(&mut system, &mut field, &mut stepper, (0.05, 40), steps)
}

/// The same fluid in a cube of edge 6 between Lees and Edwards' images, at a rate of 0.4.
fn by_shear(time: f64, seed: u64) -> Mean {
    let (dt, rate) = (0.04, 0.4);
    let space = LeesEdwards::new(DVec3::splat(6.0), Steady::new(rate).unwrap()).unwrap();
    let mut system = fluid(space, 3.0, Clock::new(dt, 1.0, seed).unwrap());
    let mut field = pairs(Dpd::new(25.0, 4.5).unwrap());
    let (mut stepper, mut viscometer) = (
        GrootWarren::new(0.65).unwrap(),
        Viscometer::new(rate).unwrap(),
    );
    run(&mut stepper, &mut system, &mut field, 500);
    for _ in 0..(time / dt) as u32 / 5 {
        run(&mut stepper, &mut system, &mut field, 4);
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut field, &mut virial).unwrap();
        let stress = Stress.measure(&system.frame(), &virial);
        viscometer.push(stress.without(Item::Random).total());
    }
    viscometer.estimate().unwrap().viscosity
}

/// The same cube at rest.
fn by_rest(time: f64, seed: u64) -> Mean {
    let (dt, every) = (0.04, 5);
    let clock = Clock::new(dt, 1.0, seed).unwrap();
    let mut system = fluid(PeriodicBox::cubic(6.0).unwrap(), 3.0, clock);
    let mut field = pairs(Dpd::new(25.0, 4.5).unwrap());
    let mut stepper = GrootWarren::new(0.65).unwrap();
    let mut green_kubo = GreenKubo::new(f64::from(every) * dt, 216.0, 1.0).unwrap();
    run(&mut stepper, &mut system, &mut field, 500);
    for _ in 0..(time / dt) as u32 / every {
        let mut mean = DMat3::ZERO;
        for _ in 0..every {
            let mut virial = Virial::default();
            stepper.step(&mut system, &mut field, &mut virial).unwrap();
            let stress = Stress.measure(&system.frame(), &virial);
            mean += stress.total() * f64::from(every).recip();
        }
        green_kubo.push(mean);
    }
    green_kubo.viscosity(4.0).unwrap()
}

/// A simple fluid in a channel: as dense everywhere, a parabola, the stress that the force imposes, layer by layer, no
/// normal stress differences, and the viscosity that it has in shear and at rest.
///
/// Seed 1, 800 time units of 1080 particles. Standard errors of a layer: 0.005 in the density of 3, 0.007 in velocities
/// up to 0.56, 0.005 in shear stresses up to 0.36, 0.04 in the normal stress differences; of the viscosity of 0.85 they
/// are 0.01 in the channel, 0.011 in shear (seed 2, 800 time units of 648 particles) and 0.04 at rest (seed 3, 2000).
/// Bounds are 4 of each: 1 % of the density, 5 % of velocity and stress, 6 % of the viscosity in flow and 19 % at rest.
/// A sign lost in folding takes all of the velocity or the stress, a pair counted in one layer instead of shared 20 %.
#[test]
fn limit_newtonian_fluid_in_a_channel_in_shear_and_at_rest() {
    let Shown { average, channel } = groot_warren(800.0, 1);
    let viscosity = channel.viscosity(&average).unwrap();
    for layer in channel.layers(&average).unwrap() {
        let y = layer.distance;
        let off = |found: Mean, expected: f64, bound: f64| {
            let off = found.value - expected;
            assert!(off.abs() < bound, "y = {y}: {found} for {expected}");
        };
        off(layer.density, 3.0, 0.03);
        off(layer.shear, layer.imposed.value, 0.02);
        off(layer.imposed, 0.15 * y, 0.002);
        off(
            layer.velocity,
            0.15 / (2.0 * viscosity.value) * (6.25 - y * y),
            0.03,
        );
        off(layer.first_difference, 0.0, 0.15);
        off(layer.second_difference, 0.0, 0.15);
    }
    let p = channel.velocity_exponent(&average).unwrap();
    let curvature = channel.zero_shear(&average, 1.0).unwrap().viscosity;
    let (in_shear, at_rest) = (by_shear(800.0, 2), by_rest(2000.0, 3));
    println!("viscosity: channel {viscosity}, its curvature {curvature}, exponent {p}");
    println!("shear {in_shear}, rest {at_rest}");
    assert!((p.value - 1.0).abs() < 0.12, "{p}");
    for (one, other, bound) in [
        (viscosity, curvature, 0.08),
        (viscosity, in_shear, 0.06),
        (viscosity, at_rest, 0.17),
        (in_shear, at_rest, 0.17),
    ] {
        assert!(
            (one.value - other.value).abs() < bound,
            "{one} against {other}"
        );
    }
    assert!((viscosity.value - 0.852).abs() < 0.042, "{viscosity}");
}

/// Twenty repeats of each of the three rheometers, seeds 11 to 30: 68 % of estimates come within one error of their mean,
/// 95 % within two. Binomial errors are 10 and 5 %: at least 7 and 15 of 20, and a mean square deviation between 0.35 and
/// 2.2 errors squared, 4 standard errors of it. Errors too small by a factor of 1.5 are caught. The means are to be that of
/// longer runs in shear at this rate, 0.842 +- 0.002, within 4 of their errors (0.0025 in shear and in the channel, 0.015 at
/// rest) and, in the channel, 2 % for a flow that changes over few free paths: found are 0.8305 at this height and, at
/// twice the height, 0.840 +- 0.003.
#[test]
#[ignore = "four minutes; cargo test -p zimm-tests --test reverse_poiseuille -- --ignored --nocapture cover"]
fn law_errors_of_three_rheometers_cover_what_they_say() {
    let channel = |seed| {
        let Shown { average, channel } = groot_warren(320.0, seed);
        channel.viscosity(&average).unwrap()
    };
    let shear = |seed| by_shear(320.0, seed);
    let rest = |seed| by_rest(640.0, seed);
    let rheometers: [(&str, &dyn Fn(u64) -> Mean); 3] =
        [("shear", &shear), ("rest", &rest), ("channel", &channel)];
    for (name, rheometer) in rheometers {
        let runs: Vec<Mean> = (11..=30).map(rheometer).collect();
        let mean = runs.iter().map(|run| run.value).sum::<f64>() / 20.0;
        let deviation = |run: &Mean| (run.value - mean).abs() / run.at_least();
        let within = |errors: f64| runs.iter().filter(|run| deviation(run) < errors).count();
        let square = runs.iter().map(|run| deviation(run).powi(2)).sum::<f64>() / 19.0;
        let told = runs
            .iter()
            .filter(|run| run.standard_error().is_some())
            .count();
        let typical = runs.iter().map(Mean::at_least).sum::<f64>() / 20.0;
        let (one, two) = (within(1.0), within(2.0));
        println!("{name}: mean {mean:.4}, error {typical:.4}, {told} told");
        println!("{name}: {one} and {two} of 20 within one and two, mean square {square:.2}");
        assert!(one >= 7 && two >= 15 && (0.35..2.2).contains(&square));
        let bound = match name {
            "shear" => 0.012,
            "rest" => 0.06,
            _ => 0.027,
        };
        assert!((mean - 0.842).abs() < bound, "{mean}");
    }
}

/// The fluid of free beads. Published by nobody but found by an independent program: 42.7 +- 1.0 at a rate of 0.1 and
/// 41.2 +- 0.4 at 0.3, pressure 377.0 +- 0.3; kinetic theory of the friction alone says 40.1.
///
/// Seed 1, 80 time units of 1500 beads in the channel, with rates up to 0.2: a standard error of 0.26 (found: 41.5); 60
/// of 648 in shear: 0.06 (found: 41.8). Bounds: 5 % of the numbers above, which is 8 errors and more, and 1.3 (3 %)
/// between both, 4 errors and the little that the fluid may thin.
#[test]
#[ignore = "a minute; cargo test -p zimm-tests --test reverse_poiseuille -- --ignored --nocapture free"]
fn reference_free_beads_of_fedosov() {
    let shown = melt(1).driven(DVec3::new(5.0, 20.0, 5.0), 0.6, (10.0, 80.0));
    show("N 1", &shown);
    let in_channel = shown.channel.viscosity(&shown.average).unwrap();
    let in_shear = melt(1).sheared(6.0, 0.3, (10.0, 60.0)).viscosity;
    assert!((in_channel.value / 42.0 - 1.0).abs() < 0.05, "{in_channel}");
    assert!((in_shear.value / 41.2 - 1.0).abs() < 0.05, "{in_shear}");
    assert!((in_channel.value - in_shear.value).abs() < 1.3);
}

/// The melt of dumbbells. An independent program found 46.3 +- 0.5 at a rate of 0.3 and 51.1 +- 1.0 at 0.1; published is
/// a zero-shear viscosity of 62.7.
///
/// Seed 1, 150 time units of 648 beads in shear, standard errors of 0.1 and 0.4 (found: 46.1 and 52.9); 200 of 1500 in
/// the channel, whose mean at rates around 0.1 has one of 0.6 (found: 52.7). Bounds: 5 % at 0.3, 7 % at 0.1, where the
/// number to compare with is known to 2 %, and 7 % between shear and channel; free beads would be 18 % below.
#[test]
#[ignore = "two minutes; cargo test -p zimm-tests --test reverse_poiseuille -- --ignored --nocapture dumbbells"]
fn reference_melt_of_dumbbells_of_fedosov() {
    let in_shear = |rate| melt(2).sheared(6.0, rate, (20.0, 150.0)).viscosity;
    let [fast, slow] = [0.3, 0.1].map(in_shear);
    assert!((fast.value / 46.3 - 1.0).abs() < 0.05, "{fast}");
    assert!((slow.value / 51.1 - 1.0).abs() < 0.07, "{slow}");
    let shown = melt(2).driven(DVec3::new(5.0, 20.0, 5.0), 0.6, (20.0, 200.0));
    show("N 2", &shown);
    let in_channel = near(&shown, 0.07..0.14);
    println!("N 2 channel, rates 0.07 to 0.14: eta {in_channel}");
    assert!(
        (in_channel.value / slow.value - 1.0).abs() < 0.07,
        "{in_channel} against {slow}"
    );
}

/// The mean viscosity of the layers with rates in a range.
fn near(shown: &Shown, rates: Range<f64>) -> Mean {
    let rheogram = Rheogram::new(vec![(shown.channel, shown.average.clone())]).unwrap();
    let mean = rheogram.of(|points| {
        let near = points
            .iter()
            .filter(|point| rates.contains(&point.rate.value));
        let viscosities: Vec<f64> = near.map(|point| point.functions.viscosity.value).collect();
        Ok(vec![
            viscosities.iter().sum::<f64>() / viscosities.len() as f64,
        ])
    });
    mean.unwrap()[0]
}

/// The melt of chains of five. An independent program found 92.8 +- 4.1 at a rate of 0.03 and 66.1 +- 1.8 at 0.1;
/// published is a zero-shear viscosity of 138.4, which is out of sight here: near the centre line the channel shows 96 +- 4.
///
/// Seed 1. In shear 600 and 300 time units of 650 beads, standard errors of 1.0 and 0.6 (found: 85.5 and 65.0); in the
/// channel 500 of 1500, whose means at rates around 0.03 and 0.1 have 2.3 and 0.8 (found: 86.7 and 64.7). Bounds, 4
/// errors of both: 18 % and 12 % of the numbers above, 12 % and 6.5 % between shear and channel; dumbbells would be 20 %
/// below at 0.1.
#[test]
#[ignore = "four minutes; cargo test -p zimm-tests --test reverse_poiseuille -- --ignored --nocapture five"]
fn reference_melt_of_chains_of_five_of_fedosov() {
    let slow = melt(5).sheared(6.0, 0.03, (100.0, 600.0)).viscosity;
    let fast = melt(5).sheared(6.0, 0.1, (40.0, 300.0)).viscosity;
    assert!((slow.value / 92.8 - 1.0).abs() < 0.18, "{slow}");
    assert!((fast.value / 66.1 - 1.0).abs() < 0.12, "{fast}");
    let shown = melt(5).driven(DVec3::new(5.0, 20.0, 5.0), 0.6, (100.0, 500.0));
    show("N 5", &shown);
    for (rates, in_shear, bound) in [(0.02..0.045, slow, 0.12), (0.08..0.125, fast, 0.065)] {
        let in_channel = near(&shown, rates.clone());
        println!("N 5 channel, rates {rates:?}: eta {in_channel}");
        assert!(
            (in_channel.value / in_shear.value - 1.0).abs() < bound,
            "{in_channel} against {in_shear}"
        );
    }
}

/// The chains of a melt in fast shear lie along the planes of shear, so that springs carry ever less: all melts come
/// down to the fluid of free beads (his section IV A), whose friction alone makes 40.1 by kinetic theory.
///
/// Seed 1, 14 time units of 650 beads. Found at rates of 0.6 and 2: 41.41 and 40.55 for free beads, of which dumbbells
/// are 6.4 +- 0.3 and 3.1 +- 0.1 % above, chains of five 18 +- 1 and 8.5 +- 0.3 %. Bounds: 3 % for free beads (errors 0.1
/// %); above them 5 and 11 % at most and above zero at a rate of 2, 8 errors and more; and less than 0.7 of what is left at
/// 0.6, where 0.48 and 0.47 have errors of 0.03. Melts that keep to another plateau, 5 % higher, are caught.
#[test]
fn limit_melts_in_fast_shear_come_down_to_free_beads() {
    let viscosities = |rate| {
        let in_shear = |beads| melt(beads).sheared(6.0, rate, (6.0, 14.0)).viscosity;
        [1, 2, 5].map(in_shear)
    };
    let [moderate, fast] = [0.6, 2.0].map(viscosities);
    assert!((fast[0].value / 40.1 - 1.0).abs() < 0.03, "{}", fast[0]);
    for (k, most) in [(1, 0.05), (2, 0.11)] {
        let excess = |melts: &[Mean; 3]| melts[k].value / melts[0].value - 1.0;
        let (moderate, fast) = (excess(&moderate), excess(&fast));
        println!("excess over free beads: {moderate:.4} at a rate of 0.6, {fast:.4} at 2");
        assert!((0.0..most).contains(&fast) && fast < 0.7 * moderate);
    }
}
