//! Beads that hang together: what an implicit scheme solves for at once.

use std::ops::Range;
use zimm_core::ForceError;

/// One connected set of beads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// Its beads, in slots of the block.
    pub(crate) beads: Range<usize>,
    /// Its bonds among those of the block. The bond before the k-th bead, counted from 0, joins this bead to an
    /// earlier one, so that the first bonds make a tree whose leaves come last; bonds that close rings follow.
    pub(crate) links: Range<usize>,
}

/// Some of the connected sets: a piece of work.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Block {
    /// Identities of the beads, slot by slot.
    pub(crate) identities: Vec<u32>,
    /// The sets. Pairs of beads with one bond come first.
    pub(crate) parts: Vec<Part>,
    /// Number of sets that are such pairs.
    pub(crate) pairs: usize,
    /// Bonds, as numbers of beads of their set.
    pub(crate) links: Vec<[u32; 2]>,
}

/// Blocks of beads, cut by their number; enough that threads have something to share.
const BEADS: usize = 1024;

/// The connected sets of all particles, in blocks.
///
/// # Errors
/// If a bond joins a particle that does not exist.
pub(crate) fn blocks(bonds: &[[u32; 2]], particles: usize) -> Result<Vec<Block>, ForceError> {
    for (bond, ends) in bonds.iter().enumerate() {
        if let Some(&identity) = ends.iter().find(|&&end| end as usize >= particles) {
            return Err(ForceError::NoSuchParticle {
                bond,
                identity,
                particles,
            });
        }
    }
    let mut sets = sets(bonds, particles);
    let is_pair = |set: &(Vec<u32>, Vec<[u32; 2]>)| set.0.len() == 2 && set.1.len() == 1;
    sets.sort_by_key(|set| !is_pair(set));
    let mut blocks: Vec<Block> = Vec::new();
    for set in sets {
        let block = match blocks.last_mut() {
            Some(block) if block.identities.len() < BEADS => block,
            _ => blocks.push_mut(Block::default()),
        };
        block.pairs += usize::from(is_pair(&set));
        let (first, link) = (block.identities.len(), block.links.len());
        block.identities.extend(set.0);
        block.links.extend(set.1);
        block.parts.push(Part {
            beads: first..block.identities.len(),
            links: link..block.links.len(),
        });
    }
    Ok(blocks)
}

/// Each connected set: its identities, and its bonds as numbers in this list.
fn sets(bonds: &[[u32; 2]], particles: usize) -> Vec<(Vec<u32>, Vec<[u32; 2]>)> {
    let mut neighbours = vec![Vec::new(); particles];
    for (bond, &[i, j]) in bonds.iter().enumerate() {
        // A bond from a bead to itself has no length and no force.
        if i != j {
            neighbours[i as usize].push((j, bond));
            neighbours[j as usize].push((i, bond));
        }
    }
    const UNSEEN: u32 = u32::MAX;
    let mut number = vec![UNSEEN; particles];
    let mut used = vec![false; bonds.len()];
    let mut sets = Vec::new();
    for root in 0..particles as u32 {
        if number[root as usize] != UNSEEN {
            continue;
        }
        number[root as usize] = 0;
        let mut beads = vec![root];
        let (mut tree, mut rings) = (Vec::new(), Vec::new());
        let mut next = 0;
        while let Some(&bead) = beads.get(next) {
            for &(other, bond) in &neighbours[bead as usize] {
                if std::mem::replace(&mut used[bond], true) {
                    continue;
                }
                let seen = &mut number[other as usize];
                if *seen == UNSEEN {
                    *seen = beads.len() as u32;
                    beads.push(other);
                    tree.push([next as u32, *seen]);
                } else {
                    rings.push([next as u32, *seen]);
                }
            }
            next += 1;
        }
        tree.extend(rings);
        sets.push((beads, tree));
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_every_bead_and_bond_is_in_one_set_and_trees_grow_from_their_roots() {
        // A ring of four with a tail, a pair, a lone bead, a pair joined twice; one bond of a bead to itself.
        let bonds = [
            [0, 1],
            [1, 2],
            [2, 3],
            [3, 0],
            [4, 2],
            [5, 6],
            [8, 9],
            [9, 8],
            [7, 7],
        ];
        let blocks = blocks(&bonds, 10).unwrap();
        assert_eq!(blocks.len(), 1);
        let block = &blocks[0];
        assert_eq!((block.pairs, block.parts.len()), (1, 4));
        let mut identities = block.identities.clone();
        identities.sort_unstable();
        assert!(identities.into_iter().eq(0..10));
        let mut found = Vec::new();
        for part in &block.parts {
            let beads = &block.identities[part.beads.clone()];
            let links = &block.links[part.links.clone()];
            for (k, &[i, j]) in links.iter().enumerate() {
                let mut ends = [beads[i as usize], beads[j as usize]];
                ends.sort_unstable();
                found.push(ends);
                if k + 1 < beads.len() {
                    assert!(j as usize == k + 1 && i < j);
                }
            }
        }
        found.sort_unstable();
        let mut expected: Vec<[u32; 2]> = bonds[..8].to_vec();
        expected.iter_mut().for_each(|ends| ends.sort_unstable());
        expected.sort_unstable();
        assert_eq!(found, expected);
    }

    #[test]
    fn extreme_a_bond_to_nowhere_is_an_error() {
        let missing = ForceError::NoSuchParticle {
            bond: 1,
            identity: 2,
            particles: 2,
        };
        assert_eq!(blocks(&[[0, 1], [1, 2]], 2), Err(missing));
    }
}
