//! A LAMMPS dump is the frame, turned.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Cell, kinds, lattice, molecule, now, particles, system, tame};
use proptest::prelude::*;
use zimm_core::{Boundary, DMat3, DVec3, IVec3, Lattice, Open, Particles, System};
use zimm_output::DumpWriter;

/// What LAMMPS' documentation says that the numbers of a dump mean.
struct Dump {
    time: f64,
    step: u64,
    kind: String,
    corner: DVec3,
    cell: DMat3,
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Dump {
    fn of<B: Boundary>(system: &System<B>) -> Self {
        let mut file = Vec::new();
        let mut writer = DumpWriter::new(&mut file).with_molecules(kinds());
        writer.write(&system.frame()).unwrap();
        drop(writer);
        let file = String::from_utf8(file).unwrap();
        let lines: Vec<&str> = file.lines().collect();
        let numbers = |line: &str| -> Vec<f64> {
            line.split(' ').map(|word| word.parse().unwrap()).collect()
        };
        assert_eq!([lines[0], lines[2]], ["ITEM: TIME", "ITEM: TIMESTEP"]);
        assert_eq!(lines[4], "ITEM: NUMBER OF ATOMS");
        let rows: Vec<_> = lines[11..].iter().map(|line| numbers(line)).collect();
        assert_eq!(rows.len().to_string(), lines[5]);
        let kind = lines[6].strip_prefix("ITEM: BOX BOUNDS ").unwrap();
        let [x, y, z] = [7, 8, 9].map(|k| numbers(lines[k]));
        let tilts = [&x, &y, &z].map(|bounds| bounds.get(2).copied().unwrap_or(0.0));
        let [xy, xz, yz] = tilts;
        // Howto_triclinic: the inverse of the formulas for the bounding box.
        let low = DVec3::new(
            x[0] - [0.0, xy, xz, xy + xz].into_iter().fold(0.0, f64::min),
            y[0] - yz.min(0.0),
            z[0],
        );
        let high = DVec3::new(
            x[1] - [0.0, xy, xz, xy + xz].into_iter().fold(0.0, f64::max),
            y[1] - yz.max(0.0),
            z[1],
        );
        let edges = high - low;
        Self {
            time: lines[1].parse().unwrap(),
            step: lines[3].parse().unwrap(),
            kind: kind.into(),
            corner: low,
            cell: DMat3::from_cols(
                DVec3::X * edges.x,
                DVec3::new(xy, edges.y, 0.0),
                DVec3::new(xz, yz, edges.z),
            ),
            names: lines[10].split(' ').skip(2).map(String::from).collect(),
            rows,
        }
    }

    fn column(&self, name: &str) -> Option<Vec<f64>> {
        let column = self.names.iter().position(|known| known == name)?;
        Some(self.rows.iter().map(|row| row[column]).collect())
    }

    fn vectors(&self, names: [&str; 3]) -> Option<Vec<DVec3>> {
        let [x, y, z] = names.map(|name| self.column(name));
        let (x, y, z) = (x?, y?, z?);
        let rows = 0..self.rows.len();
        Some(rows.map(|k| DVec3::new(x[k], y[k], z[k])).collect())
    }
}

/// The rotation between two sets of vectors, if it is one: all products agree, and so does handedness.
fn turned(before: &[DVec3], after: &[DVec3]) -> Result<(), TestCaseError> {
    prop_assert_eq!(before.len(), after.len());
    for i in 0..before.len() {
        for j in 0..=i {
            let scale = before[i].length() * before[j].length();
            let error = before[i].dot(before[j]) - after[i].dot(after[j]);
            prop_assert!(error.abs() <= 1e-13 * scale, "{} {}", i, j);
            for k in 0..j {
                let triple = |v: &[DVec3]| v[i].cross(v[j]).dot(v[k]);
                let error = triple(before) - triple(after);
                prop_assert!(error.abs() <= 1e-12 * scale * before[k].length());
            }
        }
    }
    Ok(())
}

proptest! {
    // Lattice vectors, positions, unwrapped positions and laboratory velocities, all turned together; the cell in
    // LAMMPS' form, of the same shape and around all particles.
    #[test]
    fn law_a_dump_is_the_frame_turned(
        lattice in lattice(),
        gradient in prop::array::uniform9(-2.0..2.0),
        particles in particles(tame(), tame().prop_map(|v| v.as_ivec3())),
        now in now(),
    ) {
        let gradient = DMat3::from_cols_array(&gradient);
        let cell = Cell::<true> { lattice, gradient };
        let there = System::new(cell, particles, system(Open, Particles::default(), now).clock);
        let (frame, dump) = (there.frame(), Dump::of(&there));
        prop_assert_eq!((dump.time, dump.step), (now.time, now.step));
        prop_assert_eq!(&dump.kind, "xy xz yz pp pp pp");
        prop_assert!(dump.cell.x_axis.x > 0.0 && dump.cell.y_axis.y > 0.0 && dump.cell.z_axis.z > 0.0);
        let centre = dump.corner + dump.cell * DVec3::splat(0.5);
        prop_assert!(centre.length() < 1e-13);

        let basis = lattice.basis();
        let mirror = if basis.determinant() < 0.0 { -1.0 } else { 1.0 };
        let mut before = vec![basis.x_axis, basis.y_axis, basis.z_axis * mirror];
        let mut after = vec![dump.cell.x_axis, dump.cell.y_axis, dump.cell.z_axis];
        before.extend(frame.positions);
        let positions = dump.vectors(["x", "y", "z"]).unwrap();
        after.extend(&positions);
        for &r in &positions {
            prop_assert!((dump.cell.inverse() * r).abs().max_element() < 0.5 + 1e-12);
        }
        if let Some(images) = dump.vectors(["ix", "iy", "iz"]) {
            before.extend((0..frame.len()).map(|k| frame.unwrapped(k).unwrap()));
            after.extend(positions.iter().zip(images).map(|(&r, n)| r + dump.cell * n));
        } else {
            prop_assert!(frame.images.is_empty());
        }
        if let Some(velocities) = dump.vectors(["vx", "vy", "vz"]) {
            let laboratory = |(&c, &r): (&DVec3, &DVec3)| c + gradient * r;
            before.extend(frame.velocities.iter().zip(frame.positions).map(laboratory));
            after.extend(velocities);
        } else {
            prop_assert!(frame.velocities.is_empty());
        }
        turned(&before, &after)?;

        let places = || 0..frame.len();
        let ids: Vec<f64> = places().map(|k| f64::from(frame.id(k)) + 1.0).collect();
        prop_assert_eq!(dump.column("id").unwrap(), ids);
        let types: Vec<f64> = places().map(|k| f64::from(frame.species(k)) + 1.0).collect();
        prop_assert_eq!(dump.column("type").unwrap(), types);
        let molecules: Vec<f64> = places().map(|k| f64::from(molecule(frame.id(k)))).collect();
        prop_assert_eq!(dump.column("mol").unwrap(), molecules);
        prop_assert_eq!(dump.column("mass").unwrap_or_default(), frame.masses);
    }
}

#[test]
fn reference_a_brick_is_a_brick() {
    let cell = Cell::<false> {
        lattice: Lattice::brick(DVec3::new(4.0, 2.0, 6.0)).unwrap(),
        gradient: DMat3::ZERO,
    };
    let particles = Particles::new(vec![DVec3::new(0.1, -0.7, 2.5)])
        .unwrap()
        .with_velocities(vec![DVec3::new(-1.0, 1e-20, 3e30)])
        .unwrap()
        .counting_images();
    let there = System::new(
        cell,
        particles,
        system(Open, Particles::default(), Default::default()).clock,
    );
    let mut file = Vec::new();
    DumpWriter::new(&mut file).write(&there.frame()).unwrap();
    assert_eq!(
        String::from_utf8(file).unwrap(),
        "ITEM: TIME\n0.0\nITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\n\
        ITEM: BOX BOUNDS pp pp pp\n-2.0 2.0\n-1.0 1.0\n-3.0 3.0\n\
        ITEM: ATOMS id type x y z ix iy iz vx vy vz\n\
        1 1 0.1 -0.7 2.5 0 0 0 -1.0 1e-20 3e30\n"
    );
}

// Counts that an extension has sent around the clock have no negative.
#[test]
fn extreme_the_least_image_count_is_written() {
    let basis = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
    let cell = Cell::<true> {
        lattice: Lattice::new(basis).unwrap(),
        gradient: DMat3::ZERO,
    };
    let mut particles = Particles::new(vec![DVec3::ZERO]).unwrap().counting_images();
    particles.columns_mut().images[0] = IVec3::splat(i32::MIN);
    let there = system(cell, particles, Default::default());
    let images = Dump::of(&there).vectors(["ix", "iy", "iz"]).unwrap();
    assert_eq!(images, [IVec3::splat(i32::MIN).as_dvec3()]);
}
