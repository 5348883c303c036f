//! Overview picture of the demo: the photograph, its reconstructions, the balls.

use lobe::image::{Picture, Sheet, Tone};
use lobe::render::lat_long_picture_of;
use lobe::sh::Rgb;

use super::{SWEEP, Sky, Writer};

/// Pixels between the parts.
const GAP: usize = 8;

/// Paper.
const WHITE: Rgb<f32> = Rgb::new(1.0, 1.0, 1.0);

impl Writer<'_> {
    /// Photograph and `balls` on the left, orders 1 to 6 on the right, in a file of its own, not shown on the page.
    pub(super) fn overview(&mut self, sky: &Sky, balls: &[Picture; 3]) -> anyhow::Result<()> {
        let width = self.picture;
        let photograph = Tone::PHOTOGRAPH.apply(&Picture::from(&sky.map)).resized(width, width / 2);
        let ball = (width - 2 * GAP) / 3;
        let height = width / 2 + GAP + ball;

        let small = (height - 2 * GAP) / 3;
        let orders: Vec<Picture> = (1..=SWEEP)
            .map(|order| sky.tone.apply(&lat_long_picture_of(2 * small, small, &sky.radiance.resized(order))))
            .collect();
        let sheet = Sheet { columns: 2, margin: GAP, background: WHITE.into() }.compose(&orders);

        let mut overview = Picture::filled(width + GAP + sheet.width(), height + 2 * GAP, WHITE);
        let gap = GAP as isize;
        overview.paste(&photograph, gap, gap);
        for (k, picture) in balls.iter().enumerate() {
            overview.paste(
                &picture.resized(ball, ball),
                gap + (k * (ball + GAP)) as isize,
                gap + (width / 2) as isize + gap,
            );
        }
        overview.paste(&sheet, width as isize + gap, 0);
        self.write(&sky.file("overview.png"), &overview, &Tone::PLAIN)
    }
}
