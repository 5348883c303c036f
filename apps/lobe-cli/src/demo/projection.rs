//! Projection section of the demo: exact integration beside Monte Carlo and quasi-Monte Carlo sampling.

use lobe::sh::{Coefficient as _, Expansion as _, MonteCarloOptions, Rgb, Sampling, ShVec, project_monte_carlo};

use super::{Sky, Writer, digits};

/// The order of the comparison, that of irradiance.
const ORDER: usize = 3;

impl Writer<'_> {
    pub(super) fn projection(&mut self, sky: &Sky) {
        (self.progress)("projection by sampling");
        let name = sky.bundled.name;
        self.page.section(&format!("{name}: summing beats sampling"));
        self.page.text(
            "Lobe integrates every texel of a photograph exactly. Sampling the photograph in N directions, as course \
             code does, converges slowly, and a small sun makes it worse: it is hit or missed, and what no sample has seen no \
             standard error can report.",
        );
        let exact = sky.radiance.resized(ORDER);
        let mut rows = Vec::new();
        for (title, sampling) in [
            ("random", Sampling::Random),
            ("jittered (stratified)", Sampling::Jittered),
            ("Fibonacci spiral", Sampling::Fibonacci),
        ] {
            for samples in [100, 1_600, 25_600] {
                let options = MonteCarloOptions::default().samples(samples).seed(1).sampling(sampling);
                let found = project_monte_carlo(ORDER, &options, |s| sky.map.radiance(s).widen());
                let error = norm(&(&found.sh - &exact)) / norm(&exact);
                let reported = norm(&found.standard_error) / norm(&exact);
                rows.push(vec![
                    title.into(),
                    samples.to_string(),
                    format!("{} %", digits(100.0 * error)),
                    format!("{} %", digits(100.0 * reported)),
                ]);
            }
        }
        self.page.table(&["directions", "N", "error of the 9 coefficients", "error it reports"], &rows);
        self.page
            .command(&format!("lobe project bundled:{name} --method monte-carlo --samples 25600 -o sampled.sh.json"));
    }
}

fn norm(f: &ShVec<Rgb<f64>>) -> f64 {
    let e = f.dot(f);
    (e.r + e.g + e.b).sqrt()
}
