//! Encodings section of the demo: irradiance in nine to twenty-seven numbers, each encoding on a ball of its own.

use lobe::env::irradiance_at;
use lobe::image::{Picture, Sheet, Tone, error_map};
use lobe::render::{Ball, View};
use lobe::sh::{Dir, IrradianceEncoding, Rgb, Zh3Axis, tangent_frame};

use super::{BACKDROP, Sky, Writer, digits};
use crate::sh::encodings::{Measured, irradiance_to_encode, measure};

/// Encodings that have a ball; the table has all.
const SHOWN: [IrradianceEncoding; 11] = [
    IrradianceEncoding::Sh2,
    IrradianceEncoding::Sh3,
    IrradianceEncoding::NonLinearL1,
    IrradianceEncoding::Zh3Hallucinated(Zh3Axis::Luminance),
    IrradianceEncoding::Zh3Projected(Zh3Axis::Luminance),
    IrradianceEncoding::Zh3Solved(Zh3Axis::Luminance),
    IrradianceEncoding::AmbientCubeFitted,
    IrradianceEncoding::AhdSolved,
    IrradianceEncoding::HBasis4,
    IrradianceEncoding::HBasis6,
    IrradianceEncoding::Hl2,
];

/// The error that is white on the error maps, as a share of the mean radiance of the ball.
const FULL_SCALE: f64 = 0.5;

impl Writer<'_> {
    pub(super) fn encodings(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        self.page.section(&format!("{name}: fewer numbers than nine a channel"));
        self.page.text(&format!(
            "The same ball lit by small encodings of the irradiance, beside each its error: black for none, white for {} % \
             of the mean and more, on one scale for all. The last three serve the normals on one side of a surface only: here the \
             side that the picture shows.",
            digits(100.0 * FULL_SCALE)
        ));
        (self.progress)("encodings over the whole sphere");
        let measured = measure(&sky.map, |_| ());

        let light = sky.main_direction();
        let eye = Dir::from_angles(75.0_f64.to_radians(), light.phi() + 60.0_f64.to_radians());
        let ball = Ball::new(self.ball * 3 / 4).seen(View::from_eye(eye));
        let normals: Vec<Dir> = ball.normals().into_iter().map(|(_, n)| n).collect();
        let truth = ball.lit_by_values(BACKDROP, &irradiance_at(&sky.map, &normals));
        let tone = Tone::OBJECT.fixed_for(&truth);
        let width = ball.size() * 4 / 3;
        let file = sky.file("encoding-truth.png");
        self.write(&file, &truth, &tone)?;
        self.page.figure(&file, width, "the truth, a sum over every texel");

        let irradiance = irradiance_to_encode(&sky.map);
        let full_scale = FULL_SCALE * measured.mean / std::f64::consts::PI;
        for encoding in SHOWN {
            let encoded = encoding.encode(&irradiance, tangent_frame(eye));
            let values: Vec<Rgb<f64>> = normals.iter().map(|n| encoded.eval(*n)).collect();
            let claim = ball.lit_by_values(BACKDROP, &values);
            let pair = [tone.apply(&claim), error_map(&claim, &truth, full_scale)?];
            let file = sky.file(&format!("encoding-{}.png", encoding.name()));
            self.write(&file, &side_by_side(&pair), &Tone::PLAIN)?;
            let row = measured.encodings.iter().find(|row| row.name == encoding.name());
            let rms = row.map_or(f64::NAN, |row| row.rms);
            let caption = format!("{}, {} floats, RMS error {} %", encoding.name(), encoding.floats(3), percent(rms));
            self.page.figure(&file, 2 * width, &caption);
        }
        self.encodings_table(&measured);
        self.page.command(&format!("lobe sh encodings bundled:{name}"));
        Ok(())
    }

    fn encodings_table(&mut self, measured: &Measured) {
        let row = |row: &crate::sh::encodings::Row| {
            vec![
                row.name.into(),
                row.floats.to_string(),
                if row.hemisphere { "one side" } else { "all" }.into(),
                format!("{} %", percent(row.mean)),
                format!("{} %", percent(row.rms)),
                format!("{} %", percent(row.max)),
                digits(row.lowest),
            ]
        };
        let rows: Vec<Vec<String>> = measured.encodings.iter().map(row).collect();
        let head = ["encoding", "floats", "normals", "mean error", "RMS error", "largest error", "lowest irradiance"];
        self.page.table(&head, &rows);
        self.page.text(
            "Errors in percent of the mean irradiance, over all normals and channels; those of one side averaged over surfaces \
             that face everywhere. zh3 adds one zonal number a channel to order 2: the axis is read from the other four. ahd is a constant and \
             one light. hl2-linear has no constant, which is why it fails under any sky.",
        );
    }
}

/// Two pictures in one.
fn side_by_side(pair: &[Picture; 2]) -> Picture {
    Sheet { columns: 2, margin: 0, background: BACKDROP.into() }.compose(pair)
}

/// A share in percent, three digits.
fn percent(share: f64) -> String {
    digits(100.0 * share)
}
