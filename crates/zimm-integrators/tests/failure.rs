//! A step that fails leaves no trace, in every scheme.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{Cell, Fails, Fault, Rub, bits, crowd};
use zimm_core::{AllPairs, Energy, ForceField, StepError, Stepper, System};
use zimm_integrators::{DpdBaoab, GrootWarren, Langevin, LoweAndersen, Shardlow};

type Crowd = zimm_core::Pairwise<common::Smooth, zimm_core::AllPairs>;

fn fails(fault: Option<Fault>, step: u64) -> Fails {
    Fails {
        fault,
        step,
        particle: 7,
    }
}

/// Runs 20 steps and tries any that fails once more. Answers the errors and every bit of state and tally.
fn try_twice<F: ForceField<Cell>>(
    mut stepper: impl Stepper<Cell, F>,
    mut system: System<Cell>,
    mut field: F,
) -> (Vec<StepError>, Vec<u64>) {
    let mut errors = Vec::new();
    let mut heard = Energy::default();
    while system.clock.now().step < 20 {
        let before = (bits(&system), heard);
        if let Err(error) = stepper.step(&mut system, &mut field, &mut heard) {
            assert_eq!((bits(&system), heard), before);
            errors.push(error);
        }
    }
    let mut state = bits(&system);
    state.push(heard.0.to_bits());
    (errors, state)
}

fn law_failure_leaves_no_trace<S: Stepper<Cell, (Crowd, Fails)>>(stepper: impl Fn() -> S) {
    let (system, _) = crowd(0.7, 0.01);
    let with = |fault, step| (crowd(0.7, 0.01).1, fails(fault, step));
    let (errors, smooth) = try_twice(stepper(), system.clone(), with(None, 0));
    assert!(errors.is_empty());
    // Step 0 is the evaluation of forces that are not there yet.
    for step in [0, 1, 13] {
        for fault in [Fault::Error, Fault::NaN, Fault::Infinity] {
            let (errors, bumpy) = try_twice(stepper(), system.clone(), with(Some(fault), step));
            assert_eq!(errors.len(), 1);
            match &errors[0] {
                StepError::Force { step: found, .. } => {
                    assert_eq!((fault, *found), (Fault::Error, step.max(1)))
                }
                StepError::NotFinite {
                    step: found,
                    particle,
                    force,
                } => {
                    assert_eq!((*found, *particle), (step.max(1), 7));
                    assert!(!force[1].is_finite() && fault != Fault::Error);
                }
                other => panic!("{other}"),
            }
            assert_eq!(bumpy, smooth, "{fault:?} in step {step}");
        }
    }
}

#[test]
fn law_failure_leaves_no_trace_in_groot_warren() {
    law_failure_leaves_no_trace(|| GrootWarren::new(0.65).unwrap());
}

#[test]
fn law_failure_leaves_no_trace_in_langevin() {
    law_failure_leaves_no_trace(|| Langevin::new(0.5).unwrap());
}

#[test]
fn law_failure_leaves_no_trace_in_lowe_andersen() {
    law_failure_leaves_no_trace(|| LoweAndersen::new(30.0, 1.0, AllPairs::default()).unwrap());
}

#[test]
fn law_failure_leaves_no_trace_in_shardlow() {
    law_failure_leaves_no_trace(|| Shardlow::new(Rub { gamma: 5.0 }, AllPairs::default()));
}

#[test]
fn law_failure_leaves_no_trace_in_dpd_baoab() {
    law_failure_leaves_no_trace(|| DpdBaoab::new(Rub { gamma: 5.0 }, AllPairs::default()));
}
