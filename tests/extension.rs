//! The Groot-Warren fluid in planar extension and planar mixed flow: one viscosity in all flows, nothing to be seen of
//! the cell, momentum under control.
#![allow(clippy::unwrap_used)]

mod scene;

use scene::{fluid, momentum, pairs, run};
use zimm::prelude::*;

const DT: f64 = 0.04;

/// Edges of the cell in the plane of the flow and along the neutral axis z.
///
/// Extension stretches vortices: a velocity along the contracting axis that varies along z as exp(i k z) grows at the
/// rate of the flow less nu k^2, in the equations as in nature. With nu = 0.28 the longest wave in a neutral edge of 8
/// grows at a rate of 0.2 and the fluid stirs itself; in one of 4.5 it decays at 0.35.
const EDGE: f64 = 10.0;
const NEUTRAL: f64 = 4.5;

/// The extension rate and the shear rate of flows with A : A = 0.32, that of a shear rate of 0.4.
fn mixed(mixedness: f64) -> MixedRates {
    let rates = MixedRates::from_strain_rate(1.0, mixedness);
    let square = 8.0 * rates.extension_rate.powi(2) + 2.0 * rates.shear_rate.powi(2);
    MixedRates::from_strain_rate((0.32 / square).sqrt(), mixedness)
}

fn extension(edge: f64) -> KraynikReinelt<Steady> {
    KraynikReinelt::new(edge, NEUTRAL, Steady::new(0.2).unwrap()).unwrap()
}

/// A cell of the same area, in which images come no closer than 7.
fn mixed_cell(mixedness: f64) -> PlanarMixed<Steady> {
    PlanarMixed::from_rates(EDGE, NEUTRAL, mixed(mixedness)).unwrap()
}

fn shear() -> LeesEdwards<Steady> {
    let edges = DVec3::new(EDGE, EDGE, NEUTRAL);
    LeesEdwards::new(edges, Steady::new(0.4).unwrap()).unwrap()
}

/// What is seen in a steady flow after 10 time units.
#[derive(Debug)]
struct Seen {
    viscosity: Mean,
    temperature: Mean,
    pressure: Mean,
    /// Number density within 2 of the stagnation line, and between 2 and 3.5.
    densities: [Mean; 2],
    /// <c_x x> and <c_y y> of the particles within 3.5: what the velocity field has beyond kappa r.
    excess: [Mean; 2],
}

fn see<B: Periodic>(space: B, time: f64, seed: u64) -> Seen {
    let mut system = fluid(space, 3.0, Clock::new(DT, 1.0, seed).unwrap());
    let mut field = pairs(Dpd::new(25.0, 4.5).unwrap());
    let mut stepper = GrootWarren::new(0.65).unwrap();
    run(&mut stepper, &mut system, &mut field, 250);
    let mut viscosity = FlowViscosity::new(system.boundary.gradient()).unwrap();
    let mut averages: [BlockAverage; 6] = Default::default();
    for step in 0..(time / DT) as u32 {
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut field, &mut virial).unwrap();
        let frame = system.frame();
        let stress = Stress.measure(&frame, &virial);
        viscosity.push(stress.total());
        if step % 10 == 0 {
            let temperature = KineticTemperature::default().measure(&frame, &()).unwrap();
            averages[0].push(temperature.mean());
            averages[1].push(stress.pressure());
            for (average, x) in averages[2..].iter_mut().zip(around_the_origin(&frame)) {
                average.push(x);
            }
        }
    }
    let [temperature, pressure, inner, outer, x, y] =
        averages.map(|average| average.estimate().unwrap());
    Seen {
        viscosity: viscosity.estimate().unwrap(),
        temperature,
        pressure,
        densities: [inner, outer],
        excess: [x, y],
    }
}

/// Densities within 2 and between 2 and 3.5 of the stagnation line, <c_x x> and <c_y y> within 3.5. All of that lies
/// nearer to the line than to any of its images.
fn around_the_origin<B: Periodic>(frame: &Frame<'_, B>) -> [f64; 4] {
    let mut counts = [0.0; 2];
    let mut excess = DVec3::ZERO;
    for (&r, &c) in frame.positions.iter().zip(frame.velocities) {
        let r = frame.boundary.min_image(r);
        let distance = r.x.hypot(r.y);
        if distance < 3.5 {
            counts[(distance >= 2.0) as usize] += 1.0;
            excess += c * r;
        }
    }
    let volumes = [4.0, 3.5 * 3.5 - 4.0].map(|square| std::f64::consts::PI * square * NEUTRAL);
    let number = counts[0] + counts[1];
    [
        counts[0] / volumes[0],
        counts[1] / volumes[1],
        excess.x / number,
        excess.y / number,
    ]
}

fn assert_near(what: &str, found: Mean, expected: f64, bound: f64) {
    println!("{what}: {found}, expected {expected}, bound {bound}");
    assert!(
        (found.value - expected).abs() < bound,
        "{what}: {found} against {expected}"
    );
}

/// A Newtonian fluid has one viscosity; in planar extension that is Trouton's ratio eta_1 / eta = 4. Long runs in shear
/// and at rest give 0.852(4) for this fluid. All flows heat alike, so temperature and pressure are those of shear.
///
/// Seeds 1 to 4, 500 time units of 1350 particles at A : A = 0.32. Standard error of a viscosity: 0.012, bound 4 of them
/// (6 %). In extension a run passes 100 times through the strains of a period. A missing sign or factor in friction
/// across images, as well as a wrong kinetic item, is an error of 10 % and more.
///
/// Standard errors: T 0.0013, P 0.006, densities 0.002, excess 0.01. Bounds are 4 of them, of two runs where
/// two are compared: 0.7 % in T, 0.15 % in P, 0.3 % in density, and 0.04 against the 0.5 that kappa r itself has.
#[test]
fn law_one_viscosity_in_shear_extension_and_mixed_flow() {
    let time = 500.0;
    let seen = [
        ("shear", see(shear(), time, 1)),
        ("extension", see(extension(EDGE), time, 2)),
        ("mixedness 0.5", see(mixed_cell(0.5), time, 3)),
        ("mixedness 0.1", see(mixed_cell(0.1), time, 4)),
    ];
    let in_shear = &seen[0].1;
    for (flow, seen) in &seen {
        println!("{flow}");
        assert_near("eta", seen.viscosity, 0.852, 0.048);
        assert_near("T", seen.temperature, in_shear.temperature.value, 0.0074);
        assert_near("P", seen.pressure, in_shear.pressure.value, 0.035);
        assert_near("density within 2", seen.densities[0], 3.0, 0.01);
        assert_near("density between 2 and 3.5", seen.densities[1], 3.0, 0.01);
        assert_near("<c_x x>", seen.excess[0], 0.0, 0.04);
        assert_near("<c_y y>", seen.excess[1], 0.0, 0.04);
    }
}

/// Pressure does not know the size of the box. Seeds 5 and 6, 300 time units, bound 4 errors of two runs: 0.2 %.
#[test]
fn law_pressure_is_that_of_another_box() {
    let [small, large] =
        [(8.0, 5), (12.0, 6)].map(|(edge, seed)| see(extension(edge), 300.0, seed).pressure);
    assert_near("P", small, large.value, 0.045);
}

/// Peculiar momentum along the contracting axis obeys dP/dt = rate P, so that rounding grows as exp(rate t) where it is
/// left alone, and stays rounding where it is taken off. The growth over 20 Hencky strains is that of the law to 5 %.
#[test]
fn law_momentum_grows_if_left_alone_and_is_held_at_zero_if_not() {
    let rate = 0.5;
    let space = KraynikReinelt::new(4.0, 4.0, Steady::new(rate).unwrap()).unwrap();
    let start = fluid(space, 3.0, Clock::new(0.02, 1.0, 7).unwrap());
    let mut field = pairs(Dpd::new(25.0, 4.5).unwrap());
    let mut after = |stepper: &mut GrootWarren, times: [u32; 2]| {
        let mut system = start.clone();
        field = pairs(Dpd::new(25.0, 4.5).unwrap());
        times.map(|steps| {
            run(stepper, &mut system, &mut field, steps);
            momentum(&system)
        })
    };
    let mut free = GrootWarren::new(0.65).unwrap().keeping_momentum();
    let [early, late] = after(&mut free, [1500, 500]);
    let growth = (late.y / early.y).abs().ln() / 10.0;
    println!("free: {early} {late}, growth {growth} of {rate}");
    assert!((growth - rate).abs() < 0.05 * rate);
    let [_, held] = after(&mut GrootWarren::new(0.65).unwrap(), [1500, 501]);
    println!("held: {held}");
    assert!(held.length() < 1e-10);
}

/// What is left of the motion when the flow is taken off is diffusion as at rest: along the neutral axis, and in the mean
/// of the other two, which the flow makes differ by some 6 % either way at this rate, since it slows peculiar
/// velocities down along the axis of extension and keeps them up along that of contraction.
///
/// Seeds 8 and 9, 160 time units of 1350 particles, lags of 2 to 4 time units. Standard error of D along an axis: 1.2 %,
/// bound 4 sqrt 2 of them, 0.02 of 0.29. Affine motion that is left in would be several times D.
#[test]
fn law_diffusion_relative_to_the_flow_is_that_at_rest() {
    let [rest, flow] = [(0.0, 8), (0.1, 9)].map(|(rate, seed)| {
        let rate = Steady::new(rate).unwrap();
        let space = KraynikReinelt::new(EDGE, NEUTRAL, rate).unwrap();
        let mut system = fluid(space, 3.0, Clock::new(DT, 1.0, seed).unwrap());
        let mut field = pairs(Dpd::new(25.0, 4.5).unwrap());
        let mut stepper = GrootWarren::new(0.65).unwrap();
        run(&mut stepper, &mut system, &mut field, 250);
        let mut displacement = NonAffine::default();
        let mut diffusion = MeanSquareDisplacement::new(5.0 * DT, 10..=20).unwrap();
        for _ in 0..800 {
            run(&mut stepper, &mut system, &mut field, 5);
            diffusion.push(displacement.measure(&system.frame(), &()).unwrap());
        }
        diffusion.estimate().unwrap().axes.map(|axis| axis.value)
    });
    println!("D at rest {rest:.4?}, in flow {flow:.4?}");
    let neutral_and_plane = |axes: [f64; 3]| [axes[2], 0.5 * (axes[0] + axes[1])];
    for (rest, flow) in neutral_and_plane(rest)
        .into_iter()
        .zip(neutral_and_plane(flow))
    {
        assert!((rest - flow).abs() < 0.02, "{rest} against {flow}");
    }
}

/// The long version: 5000 time units, errors three times smaller.
#[test]
#[ignore = "four minutes; cargo test -p zimm-tests --test extension -- --ignored --nocapture"]
fn reference_trouton_ratio() {
    let shear = see(shear(), 5000.0, 11).viscosity;
    let extension = see(extension(EDGE), 5000.0, 12).viscosity;
    let ratio = 4.0 * extension.value / shear.value;
    println!("eta {shear}, eta_1 / 4 {extension}, ratio {ratio:.3}");
    assert!((ratio - 4.0).abs() < 4.0 * 4.0 * 0.004 * 2.0_f64.sqrt() / 0.852);
}
