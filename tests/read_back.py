"""Reads trajectories with ASE and OVITO and prints what they found, one JSON object a frame.

    python read_back.py ase extxyz FILE...
    python read_back.py ase lammps-dump-text FILE...
    python read_back.py ovito FILE...

or has ASE write extended XYZ again:

    python read_back.py rewrite FROM TO
"""

import json
import sys


def ase_frames(form, path):
    import ase.io
    from ase.calculators.lammps import convert

    # The reader of dumps turns units of LAMMPS' style `metal` into its own; here they are turned back.
    units = {"units": "metal"} if form == "lammps-dump-text" else {}
    for atoms in ase.io.iread(path, index=":", format=form, **units):
        frame = {
            "cell": atoms.cell.tolist() if atoms.pbc.all() else None,
            "positions": atoms.positions.tolist(),
            "distances": atoms.get_all_distances(mic=bool(atoms.pbc.all())).tolist(),
        }
        if form == "extxyz":
            frame |= {
                "species": (atoms.numbers - 1).tolist(),
                "velocities": atoms.arrays["velo"].tolist(),
                "images": atoms.arrays["map_shift"].tolist(),
                "identities": atoms.arrays["id"].tolist(),
                "time": float(atoms.info["Time"]),
                "step": int(atoms.info["Timestep"]),
            }
        else:
            speed = convert(1.0, "velocity", "metal", "ASE")
            frame |= {
                "species": (atoms.arrays["type"] - 1).tolist(),
                "velocities": (atoms.get_velocities() / speed).tolist(),
                "step": int(atoms.info["timestep"]),
            }
        yield frame


def ovito_frames(path):
    import numpy
    from ovito.io import import_file

    pipeline = import_file(path, sort_particles=False)
    for number in range(pipeline.num_frames):
        data = pipeline.compute(number)
        positions = data.particles.positions[...]
        periodic = data.cell is not None and all(data.cell.pbc)
        pairs = positions[None, :, :] - positions[:, None, :]
        if periodic:
            pairs = data.cell.delta_vector(
                numpy.repeat(positions, len(positions), axis=0), numpy.tile(positions, (len(positions), 1))
            ).reshape(pairs.shape)
        columns = {
            "images": "Periodic Image",
            "masses": "Mass",
            "molecules": "Molecule Identifier",
            "identities": "Particle Identifier",
        }
        yield {
            "cell": data.cell[...][:, :3].T.tolist() if periodic else None,
            "corner": data.cell[...][:, 3].tolist() if periodic else None,
            "positions": positions.tolist(),
            "distances": numpy.linalg.norm(pairs, axis=2).tolist(),
            "velocities": data.particles.velocities[...].tolist(),
            "time": data.attributes.get("Time"),
            "step": data.attributes.get("Timestep"),
            "gradient": data.attributes.get("velocity_gradient"),
        } | {field: data.particles[name][...].tolist() for field, name in columns.items()}


def rewritten(source, target):
    import ase.io

    for atoms in ase.io.iread(source, index=":", format="extxyz"):
        ase.io.write(target, atoms, format="extxyz", append=True)
        yield {}


if __name__ == "__main__":
    tool, *arguments = sys.argv[1:]
    if tool == "ase":
        form, *files = arguments
        frames = (frame for path in files for frame in ase_frames(form, path))
    elif tool == "rewrite":
        frames = rewritten(*arguments)
    else:
        frames = (frame for path in arguments for frame in ovito_frames(path))
    for frame in frames:
        print(json.dumps(frame))
