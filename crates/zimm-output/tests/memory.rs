//! Memory does not grow with a trajectory.

#![allow(clippy::unwrap_used)]

use peak_alloc::PeakAlloc;
use std::io::{BufReader, Read};
use zimm_core::{Clock, DVec3, Open, Particles, System};
use zimm_output::{DumpWriter, XyzReader, XyzWriter};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// The same bytes, so many times.
fn repeated(bytes: &[u8], times: usize) -> impl Read {
    (0..times).fold(Box::new(std::io::empty()) as Box<dyn Read>, |rest, _| {
        Box::new(bytes.chain(rest))
    })
}

// A frame of 1000 particles is 100 kB as text and 70 kB in memory. Of 300 frames the peak is that of the second.
#[test]
fn law_memory_does_not_grow_with_the_frames() {
    let column: Vec<DVec3> = (0..1000)
        .map(|k| DVec3::splat(f64::from(k) / 7.0))
        .collect();
    let particles = Particles::new(column.clone()).unwrap();
    let particles = particles.with_velocities(column).unwrap();
    let system = System::new(Open, particles, Clock::new(0.1, 1.0, 1).unwrap());
    let mut frame = Vec::new();
    XyzWriter::new(&mut frame).write(&system.frame()).unwrap();
    assert!(frame.len() > 80_000);

    let peak = |run: &mut dyn FnMut()| {
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        run();
        MEMORY.peak_usage() - before
    };
    let mut xyz = XyzWriter::new(std::io::sink());
    let mut dump = DumpWriter::new(std::io::sink());
    let mut frames = XyzReader::new(BufReader::new(repeated(&frame, 302)));
    let mut write = |count| {
        peak(&mut || {
            for _ in 0..count {
                xyz.write(&system.frame()).unwrap();
                dump.write(&system.frame()).unwrap();
            }
        })
    };
    let mut read = |count| {
        peak(&mut || {
            for _ in 0..count {
                assert_eq!(frames.next().unwrap().unwrap().positions.len(), 1000);
            }
        })
    };
    let (first, all) = ([write(2), read(2)], [write(300), read(300)]);
    println!("bytes at the peak of 2 frames {first:?}, of 300 {all:?}");
    assert!(all[0] <= first[0] + 1000 && all[1] <= first[1] + 1000);
    assert!(all[0] < 20_000 && all[1] < 200_000);
}
