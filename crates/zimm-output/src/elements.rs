//! Symbols of the chemical elements as names of species.

/// Tools that read XYZ insist on elements, so species 0 is H, 1 is He, and so on.
const SYMBOLS: &str = "H He Li Be B C N O F Ne Na Mg Al Si P S Cl Ar K Ca Sc Ti V Cr Mn Fe Co Ni Cu Zn Ga Ge As Se Br \
    Kr Rb Sr Y Zr Nb Mo Tc Ru Rh Pd Ag Cd In Sn Sb Te I Xe Cs Ba La Ce Pr Nd Pm Sm Eu Gd Tb Dy Ho Er Tm Yb Lu Hf Ta W \
    Re Os Ir Pt Au Hg Tl Pb Bi Po At Rn Fr Ra Ac Th Pa U Np Pu Am Cm Bk Cf Es Fm Md No Lr Rf Db Sg Bh Hs Mt Ds Rg Cn \
    Nh Fl Mc Lv Ts Og";

/// The names of all 256 species; those for which there is no element are called X118 to X255.
pub(crate) fn names() -> Vec<String> {
    let beyond = (118..256).map(|species| format!("X{species}"));
    SYMBOLS
        .split_ascii_whitespace()
        .map(String::from)
        .chain(beyond)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_atomic_numbers() {
        let names = names();
        assert_eq!(names.len(), 256);
        for (number, symbol) in [
            (1, "H"),
            (26, "Fe"),
            (57, "La"),
            (79, "Au"),
            (92, "U"),
            (118, "Og"),
        ] {
            assert_eq!(names[number - 1], symbol);
        }
        let distinct: std::collections::HashSet<_> = names.iter().collect();
        assert_eq!(distinct.len(), 256);
    }
}
