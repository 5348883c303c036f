//! Section about exact integration beside Monte Carlo and quasi-Monte Carlo sampling.

use lobe::sh::Coefficient as _;
use lobe::sh::projection::{MonteCarloOptions, Sampling, project_monte_carlo};

use crate::error::Drawn;
use crate::page::{Canvas, Sky, energy, percent, relative};

/// The order of the comparison, that of irradiance.
const ORDER: usize = 3;

pub(crate) fn projection(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    canvas.step()?;
    canvas.text(
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
            let error = relative(&found.sh, &exact);
            let reported = energy(&found.standard_error).sqrt() / energy(&exact).sqrt();
            rows.push(vec![title.into(), samples.to_string(), percent(error), percent(reported)]);
        }
    }
    canvas.table(&["directions", "N", "error of the 9 coefficients", "error it reports"], &rows);
    let name = sky.bundled.name;
    canvas.command(&format!("lobe project bundled:{name} --method monte-carlo --samples 25600 -o sampled.sh.json"));
    Ok(())
}
