//! Superposition of time and temperature, and of time and concentration, in the fluids of Fedosov, Karniadakis and
//! Caswell (2010, sections IV B and C).
#![allow(clippy::unwrap_used)]

mod fedosov;
mod scene;

use fedosov::{Fluid, melt, show};
use zimm::prelude::*;

/// The melt of chains of five of his Table IV: repulsion and springs that scale with a temperature, and a friction that
/// falls with kT.
fn thermal(kt: f64, scale: f64) -> Fluid {
    Fluid {
        kt,
        repulsion: 50.0 * scale,
        friction: 4.5 / kt,
        stiffness: 100.0 * scale,
        limit: 2.0,
        ..melt(5)
    }
}

/// Viscosity over kT at four rates, 0.04 to 0.32 times a factor, in a cube of edge 5: 375 beads, 75 chains.
fn curve(fluid: Fluid, factor: f64) -> Vec<(f64, Mean)> {
    let point = |reduced: f64| {
        let rate = reduced * factor;
        let times = (4.0 / rate, (8.0 / rate).max(100.0));
        let viscosity = fluid.sheared(5.0, rate, times).viscosity;
        (rate, viscosity.times(1.0 / fluid.kt))
    };
    [0.04, 0.08, 0.16, 0.32].map(point).to_vec()
}

/// Energies that scale with kT and a friction that falls with it: without inertia the melt at kT is that at 1 with a
/// clock that is kT^2 as fast, and with stresses kT times as large. Curves of eta / kT superpose with rates / a and
/// ordinates times a, a = kT^2, found by the code. Published zero-shear viscosities (Table V: 2015.2, 1082.4 and 757.8)
/// make 0.269 and 2.14 in place of 0.25 and 2.25, the formula printed beside them 0.93 and 1.05. With energies that stay
/// as they are curves are of another shape.
///
/// Seed 1, strains of 8 or more, standard errors of viscosities from 0.4 to 2.6 %. Found: 2.222 +- 0.027 with curves 0.9
/// errors apart, 0.248 +- 0.004 with 1.15, and for constant energies 2.71 +- 0.14 with 4.4. Bounds: 7 %, which is 4 errors
/// and more, 2.5 errors and more than 3. Four points of either curve have a root mean square within 2.5 but for one run in
/// thousands.
#[test]
#[ignore = "three minutes; cargo test -p zimm-tests --test superposition -- --ignored --nocapture temperatures"]
fn reference_temperatures_superpose_if_all_energies_scale() {
    let reference = curve(thermal(1.0, 1.0), 1.0);
    for (kt, clock) in [(1.5, 2.25), (0.5, 0.25)] {
        let found = Superposition::find(&reference, &curve(thermal(kt, kt), clock), 1.0).unwrap();
        let (factor, residual) = (found.factor, found.residual);
        println!("kT {kt}: {factor}, residual {residual:.2}");
        assert!((factor.value / clock - 1.0).abs() < 0.07 && residual < 2.5);
    }
    let curve = curve(thermal(1.5, 1.0), 2.25);
    let found = Superposition::find(&reference, &curve, 1.0).unwrap();
    println!("kT 1.5, energies as at 1: {found:?}");
    assert!(found.residual > 3.0);
}

/// Half of the beads in chains of five, in a channel of height 10 and in shear. Chains drift to the centre line, yet the
/// viscosity at a rate is that in shear: the published rule of time and concentration (alpha = 0.75, found in
/// a channel of 25) does not bring the two closer; both are printed.
///
/// Seed 1. In shear 300 time units of 650 beads at each of four rates, standard errors of 0.13 to 0.8 %; in the channel
/// 1200 of 1500, 0.2 to 1.6 % a layer. Found: chains are 8 % denser than on average in the inner three layers and 8 %
/// thinner in the outer three, with an error of 1 %; viscosities off by -2.1 +- 1.7 % to +0.8 +- 0.4 % at rates from
/// 0.045 to 0.35, their root mean square 1.0 %, with the rule 1.5 %. Bounds: 3 % for the chains, 4 errors and 0.5 % for the
/// viscosities, so that 2 % shows at rates above 0.15.
#[test]
#[ignore = "seven minutes; cargo test -p zimm-tests --test superposition -- --ignored --nocapture channel"]
fn reference_a_solution_in_a_channel_is_the_one_in_shear() {
    const SOLVENT: f64 = 41.8;
    const MEAN: f64 = 1.5;
    let fluid = Fluid {
        share: 0.5,
        ..melt(5)
    };
    let point = |rate: f64| {
        let viscosity = fluid.sheared(6.0, rate, (20.0, 300.0)).viscosity;
        let error = StandardError::AtLeast(viscosity.at_least() / viscosity.value);
        let value = viscosity.value.ln();
        (rate.ln(), Mean { value, error })
    };
    let curve = PolynomialFit::<3>::new(&[0.05, 0.1, 0.2, 0.4].map(point)).unwrap();
    let in_shear = |rate: f64| {
        let ([a, b, c], x) = (curve.coefficients, rate.ln());
        (a + x * (b + x * c)).exp()
    };
    let shown = fluid.driven(DVec3::new(5.0, 20.0, 5.0), 1.2, (100.0, 1200.0));
    show("half", &shown);
    let layers = shown.channel.layers(&shown.average).unwrap();
    for layer in &layers {
        let (Some(functions), rate) = (layer.functions, layer.rate.value) else {
            continue;
        };
        let a = Superposition::of_concentration(layer.concentrations[1].value, MEAN, 0.75).unwrap();
        let (eta, error) = (functions.viscosity.value, functions.viscosity.at_least());
        let shifted = SOLVENT + (eta - SOLVENT) * a;
        let [raw, moved] = [eta / in_shear(rate), shifted / in_shear(rate / a)].map(|x| x - 1.0);
        let error = error / eta;
        println!("rate {rate:.4}: off by {raw:.4}, with the rule by {moved:.4}, error {error:.4}");
        if (0.045..0.35).contains(&rate) {
            assert!(raw.abs() < 4.0 * error + 0.005, "{raw} at {rate}");
        }
    }
    let share = |layers: &[ChannelLayer]| {
        let chains = layers.iter().map(|layer| layer.concentrations[1].value);
        chains.sum::<f64>() / layers.len() as f64 / MEAN
    };
    let [inner, outer] = [&layers[..3], &layers[layers.len() - 3..]].map(share);
    println!("chains over their mean: {inner:.4} inside, {outer:.4} outside");
    assert!((1.03..1.2).contains(&inner) && (0.8..0.97).contains(&outer));
}
