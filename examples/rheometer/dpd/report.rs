//! What the run has found: table, CSV, JSON.

use super::reference;
use super::solute::Solute;
use crate::flow::Flow;
use crate::text::{Record, aligned, unsettled, with_errors};
use serde_json::json;
use zimm::prelude::*;

/// The results at one shear rate, in DPD units unless a comment says otherwise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// The flow.
    pub(crate) flow: Flow,
    /// Its rate.
    pub(crate) rate: f64,
    /// What flows.
    pub(crate) solute: Solute,
    /// Deborah number, the longest relaxation time of Rouse's theory times the rate, with the bead friction of all rates together.
    pub(crate) deborah: f64,
    /// Standard error of the Deborah number.
    pub(crate) deborah_error: f64,
    /// Viscosity of the solution.
    pub(crate) viscosity: Mean,
    /// First normal stress coefficient of the solution.
    pub(crate) psi1: Mean,
    /// Polymer viscosity over n kT times the relaxation time.
    pub(crate) polymer_viscosity: Mean,
    /// First normal stress coefficient of the polymer over n kT times its square.
    pub(crate) polymer_psi1: Mean,
    /// <R_e^2> over the square of the contour length.
    pub(crate) extension: Mean,
    /// Kinetic temperature.
    pub(crate) temperature: Mean,
    /// Bead friction as this rate alone shows it.
    pub(crate) friction: Mean,
    /// Wall time.
    pub(crate) seconds: f64,
}

impl Row {
    /// What theory says, of dumbbells only.
    fn theory(&self) -> Option<reference::Dumbbell> {
        let known = self.solute.chain == 2;
        known
            .then(|| reference::dumbbell(self.flow, self.deborah))
            .flatten()
    }

    fn means(&self) -> [(&'static str, Mean); 7] {
        [
            ("viscosity", self.viscosity),
            ("psi1", self.psi1),
            ("polymer_viscosity", self.polymer_viscosity),
            ("polymer_psi1", self.polymer_psi1),
            ("extension", self.extension),
            ("temperature", self.temperature),
            ("friction", self.friction),
        ]
    }

    /// Every number under its name. Errors are standard errors; those of `unsettled` quantities are lower bounds.
    pub(crate) fn record(&self) -> Record {
        let theory = self.theory();
        let mut record = vec![
            ("method".into(), json!("dpd")),
            ("flow".into(), json!(self.flow.name())),
            ("rate".into(), json!(self.rate)),
            ("deborah".into(), json!(self.deborah)),
            ("deborah_error".into(), json!(self.deborah_error)),
        ];
        record.extend(with_errors(&self.means()));
        record.extend([
            (
                "theory_polymer_viscosity".into(),
                json!(theory.map(|t| t.viscosity)),
            ),
            ("theory_polymer_psi1".into(), json!(theory.map(|t| t.psi1))),
            (
                "theory_extension".into(),
                json!(theory.map(|t| t.extension)),
            ),
            ("seconds".into(), json!(self.seconds)),
            ("unsettled".into(), unsettled(&self.means())),
        ]);
        record
    }
}

/// The table and how to read it.
pub(crate) fn summary(rows: &[Row], solute: Solute, friction: Mean, relaxation: Mean) -> String {
    let (time, theory) = match solute.chain {
        2 => {
            let source = rows.first().map_or("", |row| reference::source(row.flow));
            let theory = format!("theory: beads that do not interact, {source}\n");
            ("lambda_H = zeta / 4H", theory)
        }
        _ => ("lambda_1 = zeta / (8H sin^2(pi / 2N))", String::new()),
    };
    format!(
        "{table}
bead friction zeta = {friction:#} m/tau, {time} = {relaxation:#} tau
(from Kramers = Giesekus at all rates together; De and the starred columns are in its units)
{theory}errors: 0.912(12) is 0.912 +- 0.012; (>12): the run is too short, the error may be larger
",
        table = table(rows),
    )
}

fn table(rows: &[Row]) -> String {
    let names = [
        "rate",
        "De",
        "eta",
        "Psi_1",
        "eta_p*",
        "theory",
        "Psi_1p*",
        "theory",
        if rows.iter().all(|row| row.solute.chain == 2) {
            "<Q^2>/Q_0^2"
        } else {
            "<R_e^2>/L^2"
        },
        "theory",
        "T",
    ];
    let units = [
        "1/tau",
        "",
        "kT tau/r_c^3",
        "kT tau^2/r_c^3",
        "",
        "",
        "",
        "",
        "",
        "",
        "kT",
    ];
    let mut cells = vec![names.map(String::from), units.map(String::from)];
    for row in rows {
        let theory = row.theory();
        let theory = |part: fn(&reference::Dumbbell) -> f64, digits| {
            theory
                .as_ref()
                .map_or_else(String::new, |all| format!("{:.digits$}", part(all)))
        };
        cells.push([
            row.rate.to_string(),
            format!("{:.3}", row.deborah),
            format!("{:#}", row.viscosity),
            format!("{:#}", row.psi1),
            format!("{:#}", row.polymer_viscosity),
            theory(|t| t.viscosity, 3),
            format!("{:#}", row.polymer_psi1),
            theory(|t| t.psi1, 3),
            format!("{:#}", row.extension),
            theory(|t| t.extension, 4),
            format!("{:#}", row.temperature),
        ]);
    }
    aligned(&cells)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use crate::text::{csv, json_line};
    use serde_json::Value;

    fn known(value: f64, error: f64) -> Mean {
        let error = StandardError::Plateau {
            error,
            uncertainty: 0.1 * error,
        };
        Mean { value, error }
    }

    fn row() -> Row {
        let mean = known(1.25, 0.03);
        Row {
            flow: Flow::Shear,
            rate: 0.1,
            solute: Options::of_words("rheometer").solute,
            deborah: 0.2,
            deborah_error: 0.01,
            viscosity: mean,
            psi1: Mean {
                error: StandardError::AtLeast(0.5),
                ..mean
            },
            polymer_viscosity: mean,
            polymer_psi1: mean,
            extension: mean,
            temperature: mean,
            friction: mean,
            seconds: 1.5,
        }
    }

    #[test]
    fn law_every_format_marks_what_is_not_settled() {
        let line: Value = serde_json::from_str(&json_line(row().record())).unwrap();
        assert_eq!(line["method"], "dpd");
        assert_eq!(
            (&line["viscosity"], &line["viscosity_error"]),
            (&json!(1.25), &json!(0.03))
        );
        assert_eq!(line["unsettled"], json!(["psi1"]));
        assert!(table(&[row()]).contains("1.2(>5)"));
        let csv = csv([row().record(), row().record()]);
        let lines: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| line.len() == lines[0].len()));
        assert_eq!(
            (lines[0].last(), lines[1].last()),
            (Some(&"unsettled"), Some(&"psi1"))
        );
    }

    #[test]
    fn law_theory_is_left_blank_where_there_is_none() {
        let far = Row {
            deborah: 1e3,
            ..row()
        };
        let line: Value = serde_json::from_str(&json_line(far.record())).unwrap();
        assert_eq!(line["theory_extension"], Value::Null);
        assert!(csv([far.record()]).contains(",,,"));
        let table = table(&[far]);
        let lengths: Vec<_> = table.lines().map(str::len).collect();
        assert_eq!(lengths[0], lengths[2]);
    }
}
