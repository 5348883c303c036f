//! Dering by the table of windows: what it allows for, and where it ends.

use lobe_sh::filter::scale_bands_in_place;
use lobe_sh::ringing::{DeringMethod, DeringOutcome, conservative_minimum, dering_table_factors};
use lobe_sh::{Dir, Expansion, Rgb, ShVec, Zonal};
use lobe_testkit::{Random, directions};

use crate::dering::{SUNS, with};

/// The table had no margin for rounding once.
#[test]
fn the_table_allows_for_the_rounding_of_coefficients() {
    let cosine = Zonal::clamped_cosine(3);
    for v in &directions()[..SUNS] {
        for color in [Rgb::new(1.0, 0.9, 0.7), Rgb::new(3e4, 1e-3, 7.0), Rgb::new(0.1, 0.2, 0.3)] {
            let sun = ShVec::impulse(3, Dir::from_unit(*v), color).convolved(&cosine);
            let f: ShVec<Rgb> = sun.map(|c| Rgb::new(c.r as f32, c.g as f32, c.b as f32));
            let (_, report) = f.deringed_with(&with(DeringMethod::Table));
            assert_eq!(report.outcome, DeringOutcome::Windowed, "a sun towards {v:?}");
            for (c, min) in report.after.iter().enumerate() {
                assert!(min.lo >= 0.0, "{color:?} towards {v:?}, channel {c}: {min:?}");
            }
        }
    }
}

#[test]
fn the_table_ends_at_light() {
    let (_, report) = ShVec::<f64>::impulse(5, Dir::Z, 1.0).deringed_with(&with(DeringMethod::Table));
    assert_eq!(report.outcome, DeringOutcome::BeyondTable, "five bands");
    let mut f = ShVec::<f64>::constant(3, 0.001);
    f[2] = 1.0;
    let (_, report) = f.deringed_with(&with(DeringMethod::Table));
    assert_eq!(report.outcome, DeringOutcome::BeyondTable, "no light is that directional");
}

#[test]
fn the_irradiance_of_any_light_is_within_the_table() {
    let mut random = Random::new(12);
    let mut beyond_bound = 0;
    for case in 0..300 {
        let mut light = ShVec::<f64>::zero(3);
        for _ in 0..1 + case % 4 {
            light += &ShVec::impulse(3, Dir::try_from(random.direction()).unwrap(), random.unit().powi(3));
        }
        let f = light.convolved(&Zonal::clamped_cosine(3));
        let (g, report) = f.deringed_with(&with(DeringMethod::Table));
        let is_done = matches!(report.outcome, DeringOutcome::Windowed | DeringOutcome::Unchanged);
        assert!(is_done && report.after[0].lo >= -1e-6 * g.mean(), "case {case}: {report:?}");
        let last = dering_table_factors(1.0);
        if report.factors[1] == last[1] {
            let mut windowed = f.clone();
            scale_bands_in_place(windowed.coefficients_mut(), &last[..3]);
            beyond_bound += usize::from(conservative_minimum(windowed.coefficients()) < 0.0);
        }
    }
    println!("{beyond_bound} of 300 need the minimum itself");
    assert!(beyond_bound > 0, "two suns near each other do");
}
